"""Commands that put neighbours into a new container, and take a container away."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal

from pydantic import Field

from grip_bt.base.errors import EditError, listing
from grip_bt.base.frozen import FrozenDict
from grip_bt.task.model import KINDS

from ..model import AnyNode, Leaf, Meaning, Name, StateMachine, Subtask, Task, children_of, outcomes_of
from .change_kind import STANDARD, chain, edges_of, expect_kind
from .editing import BaseCommand, Edit, PathCommand, expect_free, kind_in_words, path_in_words, slot, slot_of
from .paste import fresh_name
from .steps import Place

_SHOWN = 3
"""Names that a title lists; further ones are counted."""


class Wrap(BaseCommand):
    """Neighbours go into a new container, which takes their place and what leads to them.

    Edges and exits for labels of theirs other than success and failure become outcomes of the new container, so that
    they lead where they led.
    """

    do: Literal["wrap"] = "wrap"
    paths: tuple[str, ...] = Field(min_length=1)
    """Children of one container that stand side by side; or the root alone."""
    kind: str
    name: Name
    """Name of the container; of the child where the root is wrapped, since the root has none."""
    fields: FrozenDict[str, object] = FrozenDict()
    """Keys of the container that it needs or that differ from defaults: `{times: 3}`."""

    def in_words(self) -> str:
        shown = ", ".join(path_in_words(path) for path in self.paths[:_SHOWN])
        more = f" and {len(self.paths) - _SHOWN} more" if len(self.paths) > _SHOWN else ""
        return f"wrap {shown}{more} in {kind_in_words(self.kind)}"

    def plan(self, edit: Edit) -> None:
        expect_kind(self.paths[0], self.kind)
        if not slot_of(KINDS[self.kind]):
            raise EditError(self.paths[0], f"a {self.kind} holds no nodes; choose a container")
        shell = _Shell(self)
        if self.paths == ("/",):
            _wrap_root(edit, shell)
            return
        parent, names, container = _neighbours(edit, self)
        if slot_of(KINDS[self.kind]) == "child" and len(names) > 1:
            raise EditError(parent, f"a {self.kind} has one child; wrap {listing(names)} in a sequence first")
        expect_free(container, parent, self.name)
        shell.initial = names[0]
        if isinstance(container, StateMachine):
            _take_edges(edit, shell, parent, names)
        else:
            _take_exits(edit, shell, parent, names)
        at = (*edit.place(parent), slot(container))
        edit.put(at, self.name, shell.record(), list(children_of(container)).index(names[0]))
        for position, name in enumerate(names):
            edit.shift(at, name, (*at, self.name, slot_of(KINDS[self.kind])), position)


class Unwrap(PathCommand):
    """A container goes and its children take its place."""

    do: Literal["unwrap"] = "unwrap"
    words: ClassVar[str] = "unwrap {path}"

    def plan(self, edit: Edit) -> None:
        node = edit.container(self.path)
        names = list(children_of(node))
        if self.path == "/":
            _unwrap_root(edit, node, names)
            return
        parent, name, container = edit.parent(self.path, "")
        if len(names) != 1 and (slot(container) == "child" or isinstance(container, StateMachine) and not names):
            raise EditError(self.path, f"{parent} needs exactly one node here, not {listing(names, 'none')}")
        taken = [n for n in names if n in children_of(container) and n != name]
        if taken:
            raise EditError(self.path, f"{parent} has its own {listing(taken)}; rename one of each first")
        place, at = edit.place(self.path), (*edit.place(parent), slot(container))
        _rehome(edit, node, place, container, edit.place(parent))
        if isinstance(container, StateMachine):
            _give_edges(edit, node, place, container, name)
        else:
            _give_exits(edit, node, place, edit.place(parent), name)
        inner = (*place, slot(node))
        index = list(children_of(container)).index(name)
        if name in names:
            aside = fresh_name(name, {*names, *children_of(container)})
            edit.rekey(at, name, aside)
            name, inner = aside, (*at, aside, slot(node))
        for position, child in enumerate(names):
            edit.shift(inner, child, at, index + position)
        edit.drop(at, name)


class _Shell:
    def __init__(self, command: Wrap):
        self.kind, self.fields = command.kind, dict(command.fields)
        self.name = command.name
        self.initial = ""
        self.outcomes: dict[str, Meaning] = {}
        self.exits: dict[str, str] = {}
        self.on: dict[str, str] = {}

    @property
    def machine(self) -> bool:
        return KINDS[self.kind].by_edges

    def record(self) -> dict[str, object]:
        made: dict[str, object] = {"kind": self.kind}
        if self.machine:
            made["initial"] = self.initial
            self.outcomes = self.outcomes or {label: label for label in STANDARD}  # type: ignore[misc]
        parts = {"outcomes": self.outcomes, "exits": self.exits, "on": self.on}
        made |= {key: value for key, value in parts.items() if value}
        return {**made, **self.fields, slot_of(KINDS[self.kind]): {}}


def _neighbours(edit: Edit, command: Wrap) -> tuple[str, list[str], AnyNode]:
    found = [edit.parent(path, "is wrapped alone") for path in command.paths]
    parent, _, container = found[0]
    names = [name for _, name, _ in found]
    order = list(children_of(container))
    first = order.index(names[0])
    if any(p != parent for p, _, _ in found) or order[first : first + len(names)] != names:
        raise EditError(parent, "only children of one container that stand side by side, in their order, are wrapped")
    return parent, names, container


def _wrap_root(edit: Edit, shell: _Shell) -> None:
    root, name = edit.task.root, shell.name
    shell.initial = name
    if root.on or shell.machine:
        _pass_edges(edit, shell, ("root",), name, root, edit.task)
    aside = fresh_name("x-aside", {*edit.draft.mapping(())})
    inner = ("root", slot_of(KINDS[shell.kind]))
    edit.rekey((), "root", aside)
    edit.put((), "root", shell.record())
    edit.shift((), aside, inner)
    edit.rekey(inner, aside, name)


def _take_edges(edit: Edit, shell: _Shell, parent: str, names: list[str]) -> None:
    """Let a container within a state machine lead where its children led, and be entered where they were."""
    machine, place = edit.node(parent), edit.place(parent)
    assert isinstance(machine, StateMachine)
    at = (*place, slot(machine))
    if not shell.machine and len(names) > 1:
        raise EditError(parent, f"states become a state_machine; wrap {listing(names)} one by one, or in that")
    outside = {name: child for name, child in machine.children.items() if name not in names}
    entered = {t for child in outside.values() for t in child.on.values() if t in names}
    entered |= {machine.initial} & set(names)
    if len(entered) > 1:
        raise EditError(parent, f"{listing(sorted(entered))} are entered from outside; a container has one entry")
    shell.initial = next(iter(entered), names[0])
    for name, child in outside.items():
        for outcome, target in child.on.items():
            if target in names:
                edit.set((*at, name, "on"), outcome, shell.name)
    if machine.initial in names:
        edit.set(place, "initial", shell.name)
    if not shell.machine:
        _pass_edges(edit, shell, (*at, names[0]), names[0], machine.children[names[0]], machine)
        return
    for name in names:
        for outcome, target in machine.children[name].on.items():
            if target not in names and target not in shell.outcomes:
                shell.outcomes[target] = _meaning(machine.children[name], outcome, machine, target)
                shell.on[target] = target


def _pass_edges(
    edit: Edit, shell: _Shell, record: Place, name: str, node: AnyNode, around: StateMachine | Task
) -> None:
    """Take the `on` of the only child; what isn't success or failure becomes an outcome of the container."""
    on = dict(node.on)
    within: dict[str, str] = {}
    for outcome, target in on.items():
        label = outcome.replace(".", "_")
        if shell.machine:
            label = outcome.partition(".")[0]
            within[outcome] = label
        elif outcome.partition(".")[0] in STANDARD:
            shell.on[outcome] = shell.name if target == name else target
            continue
        else:
            shell.exits[f"{name}.{outcome}"] = label
        shell.outcomes[label] = _meaning(node, outcome, around, target)
        shell.on[label if not shell.machine else outcome] = shell.name if target == name else target
    if shell.machine:
        known = outcomes_of(node) if not isinstance(node, Leaf | Subtask) else {label: label for label in STANDARD}
        for label, meaning in known.items():
            within.setdefault(label, label)
            shell.outcomes.setdefault(label, meaning)  # type: ignore[arg-type]
        edit.set(record, "on", within)
    elif on:
        edit.drop(record, "on")


def _take_exits(edit: Edit, shell: _Shell, parent: str, names: list[str]) -> None:
    """Let labels of the children that end the container around them do so from within the new one."""
    container, place = edit.node(parent), edit.place(parent)
    within = chain(None if len(names) == 1 else container, names)
    for key, exit_ in edit.entries(place, "exits").items():
        name, _, outcome = key.partition(".")
        if name not in names:
            continue
        label = exit_ if exit_ not in STANDARD else key.replace(".", "_")
        if label in shell.outcomes:
            label = key.replace(".", "_")
        shell.outcomes[label] = _meaning(children_of(container)[name], outcome, container, exit_)
        if shell.machine:
            within[name][outcome] = label
        else:
            shell.exits[key] = label
        edit.rekey((*place, "exits"), key, f"{shell.name}.{label}")
    if shell.machine:
        reached = {t for on in within.values() for t in on.values()}
        shell.outcomes |= {label: label for label in STANDARD if label in reached}  # type: ignore[misc]
        for name, on in within.items():
            edit.set((*place, slot(container), name), "on", on)


def _meaning(node: AnyNode, outcome: str, around: AnyNode | Task, target: str) -> Meaning:
    """Return what a label most likely means: as declared below, else as declared above, else by its name."""
    label = outcome.partition(".")[0]
    below = node.meaning if isinstance(node, Leaf | Subtask) else outcomes_of(node)
    above: Mapping[str, Meaning] = getattr(around, "outcomes", {})
    found = below.get(label) or above.get(target)
    return found or ("failure" if label == "failure" else "success")


def _unwrap_root(edit: Edit, node: AnyNode, names: list[str]) -> None:
    if len(names) != 1:
        raise EditError("/", f"a task has one root; this one would leave {listing(names, 'none')}")
    _rehome(edit, node, ("root",), edit.task, ())
    inner = ("root", slot(node))
    record = (*inner, names[0])
    on = {
        outcome: node.on.get(label, label)
        for outcome, label in edges_of(node)[names[0]].items()
        if label not in names and node.on.get(label, label) in edit.task.outcomes
    }
    _set_on(edit, record, on if node.on or isinstance(node, StateMachine) else {})
    aside = fresh_name("x-aside", {*edit.draft.mapping(()), *names})
    edit.rekey(inner, names[0], aside)
    edit.shift(inner, aside, ())
    edit.drop((), "root")
    edit.rekey((), aside, "root")


def _rehome(edit: Edit, node: AnyNode, place: Place, around: AnyNode | Task, to: Place) -> None:
    """Let the variables of the container be those of the one around it."""
    own = list(getattr(node, "data", ()))
    if not own:
        return
    both = [name for name in own if name in getattr(around, "data", ())]
    if both:
        where = "the task" if to == () else "the container around it"
        raise EditError("/".join(place[2::2]), f"{where} has its own {listing(both)}; rename a variable first")
    if "data" not in edit.draft.mapping(to):
        edit.shift(place, "data", to)
        return
    for name in own:
        edit.shift((*place, "data"), name, (*to, "data"))


def _give_edges(edit: Edit, node: AnyNode, place: Place, machine: StateMachine, name: str) -> None:
    """Connect the children to where the container led, and what led to the container to its first child."""
    names = list(children_of(node))
    first = node.initial if isinstance(node, StateMachine) and node.initial in names else names[0]
    at = place[:-1]
    for sibling, child in machine.children.items():
        for outcome, target in child.on.items():
            if target == name != sibling:
                edit.set((*at, sibling, "on"), outcome, first)
    if machine.initial == name:
        edit.set(at[:-1], "initial", first)
    for inner, edges in edges_of(node).items():
        on: dict[str, str] = {}
        for outcome, label in edges.items():
            if label in names:
                on[outcome] = label
                continue
            for exit_, target in node.on.items():
                base, dot, code = exit_.partition(".")
                if base == label and (not dot or "." not in outcome):
                    on[f"{outcome}{dot}{code}"] = first if target == name else target
        _set_on(edit, (*place, slot(node), inner), on)


def _give_exits(edit: Edit, node: AnyNode, place: Place, around: Place, name: str) -> None:
    """Let the labels of the children that left the container around it through this one leave it themselves."""
    old = {key: exit_ for key, exit_ in edit.entries(around, "exits").items() if key.partition(".")[0] == name}
    for key in old:
        edit.drop_in(around, "exits", key)
    for child, edges in edges_of(node).items():
        for outcome, label in edges.items():
            if f"{name}.{label}" in old and label not in children_of(node):
                edit.set_in(around, "exits", f"{child}.{outcome}", old[f"{name}.{label}"])
        _set_on(edit, (*place, slot(node), child), {})


def _set_on(edit: Edit, record: Place, on: dict[str, str]) -> None:
    if on:
        edit.set(record, "on", on)
    elif "on" in edit.draft.mapping(record):
        edit.drop(record, "on")
