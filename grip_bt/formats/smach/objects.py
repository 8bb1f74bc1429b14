"""Machines that are there, as objects -> tasks: compiled ones, and any of SMACH, whose leaves run its own states."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from grip_bt.base.errors import GripError
from grip_bt.base.issue import Issue
from grip_bt.compilers.binding import LeafFactory, implementation_of
from grip_bt.compilers.machine_table import AGAIN, state_labels, table_of
from grip_bt.compilers.task_machine import TaskConcurrence, TaskMachine
from grip_bt.compilers.to_machine import CompiledMachine
from grip_bt.formats.imported import ImportRefusedError
from grip_bt.formats.smach.facts import facts_of
from grip_bt.formats.smach.found import ContainerInfo, StateInfo
from grip_bt.formats.smach.leaves import Leaves
from grip_bt.formats.smach.to_task import TaskMaker
from grip_bt.nodes.smach_leaf import SmachLeaf, task_name
from grip_bt.smach_compat import Container
from grip_bt.task import Leaf, Task
from grip_bt.task.catalog import Catalog, Manifest


def to_task(machine: CompiledMachine) -> Task:
    """Return the task of a compiled machine; ImportRefusedError names each place that was changed since."""
    (row,) = machine.machine._transitions.values()
    changed = [] if dict(row) == machine.ends else ["/"]
    for part in machine._resolved.root.walk():
        state = machine.by_path.get(part.path)
        if not isinstance(state, TaskMachine | TaskConcurrence):
            continue
        same = set(state.get_children()) - {AGAIN} == set(state_labels(part).values())
        if isinstance(state, TaskMachine):
            table, rows = table_of(part, state.refined), dict(state._transitions)
            rows.pop(AGAIN, None)
            same = same and rows == table.rows and state.get_initial_states() == [table.initial]
        if not same:
            changed.append(part.path)
    issues = [Issue(path, "no-equivalent", "error", "its states or edges were changed since") for path in changed]
    if issues:
        raise ImportRefusedError("the compiled machine", issues)
    return machine.task


@dataclass(frozen=True)
class FromMachine:
    """A task that does what a machine does.

    Attributes:
        task: the task.
        catalog: the built-in nodes, and one for each kind of state of the machine.
        leaf_factory: makes the leaves, which run the machine's own states: give it to `to_tree` and `to_machine`. The
            machine and the task aren't executed at the same time.
        issues: what isn't exactly as in the machine, with what to do.
    """

    task: Task
    catalog: Catalog
    leaf_factory: LeafFactory
    issues: tuple[Issue, ...] = ()

    @property
    def exact(self) -> bool:
        """Whether the task does exactly what the machine does."""
        return not self.issues


def from_machine(machine: object, name: str = "machine", *, catalog: Catalog | None = None) -> FromMachine:
    """Return the task of a machine: of a compiled one, or of any StateMachine, Sequence, Concurrence or Iterator.

    Args:
        machine: the machine; it isn't executed.
        name: of the task.
        catalog: the nodes of a compiled machine; the built-in ones by default.

    Raises:
        ImportRefusedError: it has no equivalent, or a compiled machine was changed since.
        GripError: it is none of these, or inconsistent.
    """
    if isinstance(machine, CompiledMachine):
        return FromMachine(to_task(machine), catalog or Catalog.builtin(), implementation_of)
    if not isinstance(machine, Container):
        raise GripError(
            f"a {type(machine).__name__} isn't a container of grip_bt.smach_compat: give a StateMachine, Sequence,"
            " Concurrence or Iterator (of `smach` after smach_compat.install()), or what to_machine returned"
        )
    name = task_name(name)
    leaves = _ObjectLeaves(Path(f"{name}.py"))
    found = facts_of(machine, leaves.file)
    assert isinstance(found, ContainerInfo), "a machine is one"
    for each in found.within():
        if each.verdict == "failed":
            raise GripError(f"the machine is inconsistent: {each.issues[-1].message}")
    leaves.objects = dict(_pairs(found, machine))
    task = _ObjectTaskMaker(found, name, leaves).make()
    if task is None:
        refused = (replace(i, source="", line=None, column=None) for i in _issues(found) if i.severity == "error")
        raise ImportRefusedError(f"the machine {name!r}", refused)
    nodes = Catalog.builtin().with_manifests(spec.manifest for spec in leaves.specs.values())
    return FromMachine(task, nodes, leaves.factory(), tuple(_issues(found)))


def _pairs(found: ContainerInfo, live: Any) -> Iterator[tuple[StateInfo, Any]]:
    """Yield what was read of each object, and the object."""
    yield found, live
    for label, child in live.get_children().items():
        state = found.added[str(label)].state
        if isinstance(state, ContainerInfo):
            yield from _pairs(state, child)
        else:
            yield state, child


def _issues(found: ContainerInfo) -> list[Issue]:
    return [issue for each in found.within() for issue in each.issues]


class _ObjectLeaves(Leaves):
    """Leaves whose states are objects of this process."""

    def __init__(self, file: Path):
        super().__init__(file)
        self.objects: dict[StateInfo, object] = {}
        self.sources: dict[str, object] = {}
        self.firsts: dict[str, tuple[object, str]] = {}

    def source(self, found: StateInfo) -> str:
        """Return a name for an object."""
        name = f"live_{list(self.objects).index(found)}"
        self.sources[name] = self.objects[found]
        return name

    def factory(self) -> LeafFactory:
        specs = {spec.manifest.id: spec for spec in self.specs.values()}

        def make(path: str, node: Leaf, manifest: Manifest) -> Any:
            spec = specs.get(manifest.id)
            if spec is None or spec.source not in self.sources:
                return implementation_of(path, node, manifest)
            params = {"unwritten": [], **node.with_}
            leaf = SmachLeaf(path.rsplit("/", 1)[-1], path, manifest, params, dict(node.meaning))
            live = self.sources[spec.source]
            leaf.make = lambda: live  # type: ignore[method-assign]
            leaf.first = {key: _first(*self.firsts[text]) for key, (_, text) in spec.first.items()}  # type: ignore[misc]
            return leaf

        return make


class _ObjectTaskMaker(TaskMaker):
    """Makes the task of objects: what YAML can't hold of their userdata is taken from there."""

    leaves: _ObjectLeaves
    may_be_one_leaf = False

    def _first(self, variable: str) -> str:
        key, where = self.variables.first[variable]
        text = f"first_{variable}"
        self.leaves.firsts[text] = (self.leaves.objects[where], key)
        return text


def _first(container: Any, key: str) -> Callable[[Any], Any]:
    return lambda leaf: container.userdata[key]
