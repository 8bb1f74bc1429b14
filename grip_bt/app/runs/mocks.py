"""Scripts in place of nodes, so that a task is tried without parts that it needs, and faults of its simulated world."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from grip_bt.app.wiring.parts import Resources
from grip_bt.base.errors import DocumentError, GripError, UnknownNameError
from grip_bt.base.frozen import FrozenDict
from grip_bt.base.yaml.models import Settings, read_model
from grip_bt.compilers.binding import LeafFactory, implementation_of
from grip_bt.compilers.resolve import Part, resolve
from grip_bt.nodes.mock import MockLeaf, MockStep
from grip_bt.nodes.node import Observer
from grip_bt.runtime import Runner
from grip_bt.runtime.debugger import node_path
from grip_bt.task.catalog import Catalog, Manifest
from grip_bt.task.model import AnyNode, Leaf, Task, children_of, join
from grip_sim.faults import Fault, read_faults

Script = str | MockStep | list[str | MockStep]


class MocksFile(Settings):
    """Scripts in place of nodes."""

    mocks: dict[str, Script]
    """Path of a node, or a type of leaf -> `outcome`, `outcome.code`, several with commas between them, or steps."""


def read_mocks(file: Path | None, given: Sequence[str] = ()) -> dict[str, list[dict[str, Any]]]:
    """Return node -> steps, as JSON data, of a file and of what the command line adds to it.

    Args:
        file: YAML, `mocks: {node: script}`; None for none. A script is `outcome`, `outcome.code`, a mapping with
            `outcome`, `code`, `message`, `outputs`, `seconds`, `times`, or a list of these.
        given: texts such as `attempt/grasp=failure.no_ik,success`, which replace what the file says of a node.

    Raises:
        DocumentError: a script can't be read.
    """
    scripts: dict[str, Script] = dict(read_model(file, MocksFile).mocks) if file is not None else {}
    for text in given:
        node, found, script = text.partition("=")
        if not found or not node.strip() or not script.strip():
            raise DocumentError(f"{text!r} isn't NODE=SCRIPT, such as attempt/grasp=failure.no_ik,success", "--mock")
        scripts[node] = script
    return scripted(scripts)


def scripted(scripts: Mapping[str, Script]) -> dict[str, list[dict[str, Any]]]:
    """Return node -> steps, as JSON data, of scripts."""
    return {node_path(node): [step.model_dump() for step in _steps(script)] for node, script in scripts.items()}


def _steps(script: Script) -> list[MockStep]:
    if isinstance(script, MockStep):
        return [script]
    if isinstance(script, list):
        return [step for part in script for step in _steps(part)] or [MockStep()]
    steps = []
    for word in script.split(","):
        outcome, _, code = word.strip().partition(".")
        steps.append(MockStep(outcome=outcome, code=code))
    return steps


def apply_mocks(task: Task, catalog: Catalog, mocks: Mapping[str, Any]) -> tuple[Task, Catalog, LeafFactory]:
    """Return what to compile in place of a task so that its mocked nodes play their scripts.

    A script is a node's, or that of every leaf of a type. A leaf is replaced as it is, ports and all. A container or
    subtask becomes one leaf with its outcomes; the outputs of its script are variables around it.

    Raises:
        UnknownNameError: there is no such node, outcome, code, output or variable; it lists those that there are.
        DocumentError: a step isn't one.
    """
    parts = {part.path: part for part in resolve(task, catalog).root.walk()}
    steps: dict[str, list[MockStep]] = {}
    for name in sorted(mocks, key=parts.__contains__):  # a node's own script is the last word
        of_type = [p for p, part in parts.items() if isinstance(part.node, Leaf) and part.node.node == name]
        if name in parts or of_type or name not in catalog:
            paths = [name] if name in parts or not of_type else of_type
            steps |= {path: _checked(path, parts, mocks[name]) for path in paths}
    faces: list[Manifest] = []
    root = _replaced("/", task.root, parts, steps, faces)

    def make(path: str, node: Leaf, manifest: Manifest) -> Any:
        if path not in steps:
            return implementation_of(path, node, manifest)
        name = path.rsplit("/", 1)[-1] or manifest.id
        return MockLeaf(name, path, manifest, dict(node.meaning), steps[path])

    return task.model_copy(update={"root": root}), catalog.with_manifests(faces), make


def _checked(path: str, parts: Mapping[str, Part], script: Sequence[Mapping[str, Any]]) -> list[MockStep]:
    if path not in parts:
        raise UnknownNameError("node", path, parts, "a mock")
    part, where = parts[path], f"mock of {path}"
    ports = part.manifest.outputs if part.manifest is not None else part.around.visible()
    codes = part.manifest.codes if part.manifest is not None else ()
    try:
        steps = [MockStep.model_validate(given) for given in script]
    except ValidationError as error:
        raise DocumentError(str(error), where) from None
    for step in steps:
        if step.outcome not in part.meaning:
            raise UnknownNameError("outcome", step.outcome, part.meaning, where)
        if step.code and codes and step.code not in codes:
            raise UnknownNameError("failure code", step.code, codes, where)
        for port in step.outputs.keys() - ports:
            raise UnknownNameError("output", port, ports, where)
    return steps


def _replaced(
    path: str, node: AnyNode, parts: Mapping[str, Part], steps: Mapping[str, list[MockStep]], faces: list[Manifest]
) -> AnyNode:
    if isinstance(node, Leaf):
        return node
    if path in steps:
        written = sorted({variable for step in steps[path] for variable in step.outputs})
        face = Manifest(
            id=f"mock/node_{len(faces)}",
            doc=f"A script in place of {path}.",
            implementation="grip_bt.nodes.mock:MockLeaf",
            outputs=FrozenDict({name: {"type": "Any"} for name in written}),
            outcomes=FrozenDict(parts[path].meaning),
        )
        faces.append(face)
        out = FrozenDict({name: name for name in written})
        return Leaf(node=face.id, doc=node.doc, precondition=node.precondition, on=node.on, out=out)
    children = children_of(node)
    new = {name: _replaced(join(path, name), child, parts, steps, faces) for name, child in children.items()}
    if all(new[name] is child for name, child in children.items()):
        return node
    return node.model_copy(update={"children" if hasattr(node, "children") else "child": FrozenDict(new)})


def check_nodes(faults: Mapping[str, Fault], nodes: Collection[str]) -> None:
    """Raise UnknownNameError where a fault waits for a node that the task doesn't have."""
    for name, fault in faults.items():
        if fault.node and node_path(fault.node) not in nodes:
            raise UnknownNameError("node", fault.node, nodes, f"faults/{name}/node")


class _AtNodes(Observer):
    def __init__(self, entered: Callable[[str], None], nodes: Iterable[str]):
        self._entered, self._nodes = entered, {node_path(node): node for node in nodes}

    def entered(self, path: str) -> None:
        if path in self._nodes:
            with suppress(GripError):  # a simulator that is lost is told of by whoever moves it
                self._entered(self._nodes[path])


@contextmanager
def injected(resources: Resources, runner: Runner, tell: Callable[[str, str], None]) -> Iterator[None]:
    """Have the faults of the simulated world happen while the block runs, and those that come during the run.

    It begins before the runner does.
    """
    world = resources.world
    if world is None:
        yield
        return
    faults, servers, hanging = dict(world.spec.faults), resources.servers, set[str]()

    def happened(name: str, words: str, over: bool) -> None:
        fault = faults[name]
        server = servers.get(fault.of) if fault.fault.startswith("component_") else None
        if server is not None:
            _signal(server(), fault.fault, over)
            hanging.add(fault.of)
        tell("fault", f"{name}: {words}")

    def inject(given: str) -> None:
        for name, fault in read_faults([given]).items():
            if fault.node:
                raise GripError(f"{name}: a fault that waits for a node is given when the run starts, by --fault")
            if fault.fault.startswith("component_") and fault.of not in servers:
                raise UnknownNameError("component", fault.of, servers, f"{name}/of")
            faults[name] = fault
            world.inject(name, fault)

    world.on_fault, runner.inject = happened, inject
    if any(fault.node for fault in faults.values()):
        runner.observe(_AtNodes(world.entered, [fault.node for fault in faults.values() if fault.node]))
    try:
        yield
    finally:
        for component in hanging:  # what hangs doesn't end when it is asked to
            _signal(servers[component](), "component_hang", over=True)


def _signal(pid: int, kind: str, over: bool) -> None:
    word = signal.SIGCONT if over else signal.SIGKILL if kind == "component_death" else signal.SIGSTOP
    with suppress(ProcessLookupError):
        os.kill(pid, word)
