"""The command that puts neighbours into a new container."""

from __future__ import annotations

from typing import Any

from grip_bt.base.errors import EditError, listing

from ..model import AnyNode, Leaf, Meaning, StateMachine, Subtask, Task
from ..walking import children_of, outcomes_of
from .commands import Wrap
from .editing import Editing, expect_free, slot
from .kinds import STANDARD, chain, expect_kind, holds_nodes_of_kind, slot_of_kind
from .steps import Place


class _Shell:
    """The new container: what of its neighbours' edges and exits goes on it."""

    def __init__(self, command: Wrap):
        self.kind, self.fields = command.kind, dict(command.fields)
        self.name = command.name
        self.initial = ""
        self.outcomes: dict[str, Meaning] = {}
        self.exits: dict[str, str] = {}
        self.on: dict[str, str] = {}

    @property
    def machine(self) -> bool:
        return self.kind == "state_machine"

    def record(self) -> dict[str, Any]:
        """Return the container as it stands in a file, still without children."""
        made: dict[str, Any] = {"kind": self.kind}
        if self.machine:
            made["initial"] = self.initial
            self.outcomes = self.outcomes or {label: label for label in STANDARD}  # type: ignore[misc]
        parts = {"outcomes": self.outcomes, "exits": self.exits, "on": self.on}
        made |= {key: value for key, value in parts.items() if value}
        return {**made, **self.fields, slot_of_kind(self.kind): {}}


def wrap(editing: Editing, command: Wrap) -> None:
    """Put neighbours into a new container."""
    expect_kind(command.paths[0], command.kind)
    if not holds_nodes_of_kind(command.kind):
        raise EditError(command.paths[0], f"a {command.kind} holds no nodes; choose a container")
    shell = _Shell(command)
    if command.paths == ("/",):
        _wrap_root(editing, shell)
        return
    parent, names, container = _neighbours(editing, command)
    if slot_of_kind(command.kind) == "child" and len(names) > 1:
        raise EditError(parent, f"a {command.kind} has one child; wrap {listing(names)} in a sequence first")
    expect_free(container, parent, command.name)
    shell.initial = names[0]
    if isinstance(container, StateMachine):
        _take_edges(editing, shell, parent, names)
    else:
        _take_exits(editing, shell, parent, names)
    at = (*editing.place(parent), slot(container))
    editing.put(at, command.name, shell.record(), list(children_of(container)).index(names[0]))
    for position, name in enumerate(names):
        editing.shift(at, name, (*at, command.name, slot_of_kind(command.kind)), position)


def _neighbours(editing: Editing, command: Wrap) -> tuple[str, list[str], AnyNode]:
    found = [editing.parent(path, "is wrapped alone") for path in command.paths]
    parent, _, container = found[0]
    names = [name for _, name, _ in found]
    order = list(children_of(container))
    first = order.index(names[0])
    if any(p != parent for p, _, _ in found) or order[first : first + len(names)] != names:
        raise EditError(parent, "only children of one container that stand side by side, in their order, are wrapped")
    return parent, names, container


def _wrap_root(editing: Editing, shell: _Shell) -> None:
    root, name = editing.task.root, shell.name
    shell.initial = name
    if root.on or shell.machine:
        _pass_edges(editing, shell, ("root",), name, root, editing.task)
    aside = "x-aside"
    while aside in editing.draft.mapping(()):
        aside += "-"
    inner = ("root", slot_of_kind(shell.kind))
    editing.rekey((), "root", aside)
    editing.put((), "root", shell.record())
    editing.shift((), aside, inner)
    editing.rekey(inner, aside, name)


def _take_edges(editing: Editing, shell: _Shell, parent: str, names: list[str]) -> None:
    """Let a container within a state machine lead where its children led, and be entered where they were."""
    machine, place = editing.node(parent), editing.place(parent)
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
                editing.set((*at, name, "on"), outcome, shell.name)
    if machine.initial in names:
        editing.set(place, "initial", shell.name)
    if not shell.machine:
        _pass_edges(editing, shell, (*at, names[0]), names[0], machine.children[names[0]], machine)
        return
    for name in names:
        for outcome, target in machine.children[name].on.items():
            if target not in names and target not in shell.outcomes:
                shell.outcomes[target] = _meaning(machine.children[name], outcome, machine, target)
                shell.on[target] = target


def _pass_edges(
    editing: Editing, shell: _Shell, record: Place, name: str, node: AnyNode, around: StateMachine | Task
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
        editing.set(record, "on", within)
    elif on:
        editing.drop(record, "on")


def _take_exits(editing: Editing, shell: _Shell, parent: str, names: list[str]) -> None:
    """Let labels of the children that end the container around them do so from within the new one."""
    container, place = editing.node(parent), editing.place(parent)
    within = chain(None if len(names) == 1 else container, names)
    for key, exit_ in editing.entries(place, "exits").items():
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
        editing.rekey((*place, "exits"), key, f"{shell.name}.{label}")
    if shell.machine:
        reached = {t for on in within.values() for t in on.values()}
        shell.outcomes |= {label: label for label in STANDARD if label in reached}  # type: ignore[misc]
        for name, on in within.items():
            editing.set((*place, slot(container), name), "on", on)


def _meaning(node: AnyNode, outcome: str, around: Any, target: str) -> Meaning:
    """Return what a label most likely means: as declared below, else as declared above, else by its name."""
    label = outcome.partition(".")[0]
    below = node.meaning if isinstance(node, Leaf | Subtask) else outcomes_of(node)
    above = around.outcomes
    found = below.get(label) or above.get(target)
    return found or ("failure" if label == "failure" else "success")
