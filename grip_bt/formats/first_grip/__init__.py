"""Tasks and configurations of the first GRIP -> a project: read as data; nothing that is in them is run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grip_bt.base.errors import DocumentError, GripError
from grip_bt.base.yaml.tree import parse, read_file, to_data
from grip_bt.formats.imported import Imported, Issues, Request, manifests_text
from grip_bt.formats.names import free, key_of
from grip_bt.task import FrozenDict, Meaning, Task
from grip_bt.task.catalog.manifest import InputPort, Manifest, OutputPort, Parameter
from grip_bt.task.model import Leaf, walk

from .project import MARK, Configuration, project_texts, take_file
from .states import STATES, ImportContext, node_of
from .tasks import GripContainer, GripState, broken_if_invalid, name_of, outcome_meanings, text_task

_FILES = (".ini", ".scene", ".yaml", ".yml")
_OF_EDITOR = (
    "files of the first GRIP's editor (.ini) aren't read: give the folder of the robot's YAML files and the task in its"
    " text form (YAML), or draw the task anew (grip gui)"
)


def read(request: Request) -> Imported:
    """Read tasks and configurations of the first GRIP; nothing is run, and nothing is written.

    Args:
        request: of a YAML file of a task in text form or of a robot's configuration, or a folder of such.

    Raises:
        DocumentError: it can't be read.
        GripError: there is nothing of the first GRIP in it, or a task is broken.
    """
    path = request.path
    if not path.exists():
        raise GripError(f"{path}: there is no such file or folder")
    files = sorted(p for p in path.rglob("*") if p.suffix in _FILES) if path.is_dir() else [path]
    found, issues = Configuration(), Issues()
    originals: list[GripContainer] = []
    for file in files:
        if file.suffix == ".ini":
            if file == path:
                raise GripError(f"{path}: {_OF_EDITOR}")
            found.issues.add("incomplete", file.name, _OF_EDITOR)
        elif file.suffix == ".scene":
            found.scene = file
        elif (data := _task_data(file)) is not None:
            originals.append(text_task(data, file.name))
        else:
            take_file(found, file)
    if not originals and not found.parts:
        said = "".join(f"\n  {issue}" for issue in found.issues)
        raise GripError(f"{path}: there is no task and no configuration of the first GRIP in it{said}")
    copies = {found.scene.name: found.scene} if found.parts and found.scene is not None else {}
    tasks: dict[str, Task] = {}
    unknown: dict[str, GripState] = {}
    for root in originals:
        context = ImportContext(found, unknown, issues)
        task = _task(root, context)
        tasks[free(key_of(task.name), tasks)] = task
    used = {n.node.partition("/")[0] for task in tasks.values() for _, n in walk(task.root) if isinstance(n, Leaf)}
    moving = used & {"arm", "hand", "scene"}
    texts = project_texts(found, moving) if found.parts or moving else {}
    if unknown:
        texts |= _nodes(unknown)
    return Imported(tasks, (*found.issues, *issues), files=texts, copies=copies)


def _task_data(file: Path) -> Mapping[str, object] | None:
    """Return a task in the text form; None where the file is something else."""
    try:
        data = to_data(parse(read_file(file), str(file)))
    except DocumentError:
        return None
    return data if isinstance(data, dict) and isinstance(data.get("states"), list) else None


def _nodes(unknown: Mapping[str, GripState]) -> dict[str, str]:
    manifests, classes = [], []
    for id_, state in unknown.items():
        cls = "".join(word.capitalize() for word in id_.partition("/")[2].split("_"))
        outcomes = tuple(map(name_of, state.outcomes))
        slots = [key_of(slot) for slot in state.slots if slot != "output"]
        ports = [*(["output"] if "output" in state.slots else []), *map(key_of, state.writes)]
        manifest = Manifest(
            id=id_,
            doc=f"{state.type or state.name}, a state of the first GRIP.",
            implementation=f"leaves.py:{cls}",
            parameters=FrozenDict({slot: Parameter(type="Any", default=None) for slot in slots}),
            inputs=FrozenDict({n: InputPort(type="Any", required=False) for n in [*slots, *map(key_of, state.reads)]}),
            outputs=FrozenDict({port: OutputPort(type="Any", on=outcomes) for port in ports}),
            outcomes=FrozenDict(outcome_meanings(outcomes)),
        )
        manifests.append(manifest)
        classes.append(_class(cls, state, outcomes))
    head = f'"""States of the first GRIP; write what they do. {MARK}."""\n\nfrom grip_bt import Leaf\n'
    return {
        "nodes/original/manifest.yaml": manifests_text(manifests, f"# {MARK}.\n"),
        "nodes/original/leaves.py": head + "".join(classes),
    }


def _class(cls: str, state: GripState, outcomes: tuple[str, ...]) -> str:
    about = f"{state.type or state.name} has to be written: read self.params, return self.end(one of {list(outcomes)})"
    doc = f"{state.type or state.name} of the first GRIP.".replace("\\", "").replace('"', "'")
    return (
        f'\n\nclass {cls}(Leaf):\n    """{doc}"""\n\n    def update(self):\n'
        f"        raise NotImplementedError({about!r})\n"
    )


def _task(root: GripContainer, context: ImportContext) -> Task:
    """Return the task; what isn't as it was is added to the context's issues."""
    for state in root.states():
        output, stored = state.slots.get("output"), state.slots.get("output_type")
        if output and (not stored or state.type == "Select"):
            context.produced.add(name_of(str(output)))
        if state.type not in STATES:
            context.produced.update(map(name_of, state.writes))
        if state.type == "ComputePlan" and state.slots.get("plan_name"):
            context.produced.add(name_of(str(state.slots["plan_name"])))
    node = _container(root, context, root.name)
    document = {
        "grip": 1,
        "name": name_of(root.name),
        "doc": "Imported from a task of the first GRIP.",
        "outcomes": _outcomes(root),
        "data": context.variables,
        "root": node,
    }
    with broken_if_invalid(root.name):
        return Task.model_validate(document)


def _container(found: GripContainer, context: ImportContext, place: str) -> dict[str, Any]:
    names: dict[str, str] = {}
    taken = {name_of(outcome) for outcome in found.outcomes}
    for label in found.children:
        names[label] = name_of(label, taken)
        taken.add(names[label])
        if names[label] != label:
            context.issues.add("changed", place, f"the state {label!r} is called {names[label]!r}")
    if found.concurrent:
        return _parallel(found, names, context, place)
    children = {}
    for label, child in found.children.items():
        node, ends = _child(child, context, f"{place}/{label}")
        on = {end: _target(found, child, outcome, names, context, place) for outcome, end in ends.items()}
        children[names[label]] = {**node, "on": on}
    if found.initial not in names:
        raise GripError(f"{place}: it begins with {found.initial!r}, which isn't there")
    initial = names[found.initial]
    return {"kind": "state_machine", "initial": initial, "outcomes": _outcomes(found), "children": children}


def _outcomes(found: GripContainer) -> dict[str, Meaning]:
    return {name_of(outcome): meaning for outcome, meaning in outcome_meanings(found.outcomes).items()}


def _parallel(found: GripContainer, names: dict[str, str], context: ImportContext, place: str) -> dict[str, object]:
    """Return a parallel that waits for all and goes by rules; SMACH takes the rule with the most conditions."""
    children, ends = {}, {}
    for label, child in found.children.items():
        children[names[label]], ends[label] = _child(child, context, f"{place}/{label}")
    rules = []
    for outcome, when in sorted(found.rules.items(), key=lambda rule: -len(rule[1])):
        if unknown := [label for label in when if label not in names]:
            context.issues.add("incomplete", place, f"a rule for {outcome!r} names {unknown}, which aren't there")
            continue
        said = {names[label]: [ends[label].get(end, name_of(end))] for label, end in when.items()}
        rules.append({"when": said, "then": name_of(outcome)})
    rules.append({"then": name_of(found.default)})
    own = {outcome: meaning for outcome, meaning in _outcomes(found).items() if outcome not in ("success", "failure")}
    return {"kind": "parallel", "cancel": "join", "rules": rules, "outcomes": own, "children": children}


def _child(child: GripState, context: ImportContext, place: str) -> tuple[dict[str, object], dict[str, str]]:
    if isinstance(child, GripContainer):
        node = _container(child, context, place)
        ends = {outcome: name_of(outcome) for outcome in child.outcomes}
        if child.concurrent:  # a parallel may end with these too, as far as its document says
            ends |= {end: end for end in ("success", "failure") if end not in ends.values()}
        return node, ends
    return node_of(child, context, place)


def _target(
    found: GripContainer, child: GripState, outcome: str, names: dict[str, str], context: ImportContext, place: str
) -> str:
    target = child.leads.get(outcome)
    if target in names:
        return names[str(target)]
    if target in found.outcomes:
        return name_of(str(target))
    meanings = _outcomes(found)
    bad = next((end for end in reversed(meanings) if meanings[end] == "failure"), name_of(found.outcomes[-1]))
    if outcome in child.outcomes:
        text = f"{outcome!r} of {child.name!r} led to {target or 'nothing'}; it leads to {bad!r}"
        context.issues.add("incomplete", place, text)
    return bad
