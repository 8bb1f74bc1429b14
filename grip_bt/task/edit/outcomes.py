"""The command that renames an outcome; what speaks of it inside and around its container follows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Literal

from grip_bt.base.errors import EditError, listing, nearest

from ..canonical import file_data
from ..model import AnyNode, Kind, Leaf, Name, StateMachine, Subtask, Task, default_outcome, kind_of, outcomes_of
from .change_kind import STANDARD
from .editing import Edit, PathCommand
from .steps import Place


class RenameOutcome(PathCommand):
    """An outcome that a container declares, or (with an empty path) the task, is called `to`.

    What leads to it inside and what leads on from it around the container follows: `exits`, `on` and `rules`. Nothing
    of what the task does changes.
    """

    do: Literal["rename_outcome"] = "rename_outcome"
    words: ClassVar[str] = "rename the outcome {outcome} of {path} to {to}"
    outcome: str
    to: Name

    def plan(self, edit: Edit) -> None:
        _expect_declared(edit, self)
        if self.to != self.outcome:
            _of_task(edit, self) if self.path == "" else _of_container(edit, self)


def _expect_declared(edit: Edit, command: RenameOutcome) -> None:
    """Refuse an outcome that isn't declared there, and a name that is taken."""
    holder = edit.task if command.path == "" else edit.node(command.path)
    if not isinstance(holder, Task | Kind) or "outcomes" not in type(holder).model_fields:
        raise EditError(command.path, f"the outcomes of a {kind_of(holder)} aren't its task's to rename")
    there = holder.outcomes
    if command.outcome not in there:
        own = f"a {kind_of(holder)} keeps its {command.outcome!r}; " if command.outcome in STANDARD else ""
        hint = nearest(command.outcome, there)
        message = f"{own}no outcome {command.outcome!r} is declared here{hint} (available: {listing(there)})"
        raise EditError(command.path, message)
    every: Mapping[str, object] = there if isinstance(holder, Task) else outcomes_of(holder)
    if command.to != command.outcome and command.to in every:
        raise EditError(command.path, f"there is an outcome {command.to!r} already")
    if getattr(holder, "precondition", "") and "failure" in (command.outcome, command.to):
        raise EditError(command.path, "its precondition ends it with 'failure' too; take the precondition out first")
    if isinstance(holder, StateMachine) and command.to in holder.children:
        raise EditError(command.path, f"an edge to {command.to!r} would mean the child of that name; choose another")


def _of_task(edit: Edit, command: RenameOutcome) -> None:
    task = edit.task
    if "outcomes" in edit.draft.mapping(()):
        edit.rekey(("outcomes",), command.outcome, command.to)
    else:
        renamed = {command.to if k == command.outcome else k: v for k, v in task.outcomes.items()}
        edit.put((), "outcomes", renamed)
    led = [label for label, target in task.root.on.items() if target == command.outcome]
    for label in led:
        edit.set(("root", "on"), label, command.to)
    for label, meaning in _ends_of_root(task.root, command.outcome, bool(led)).items():
        if label not in task.root.on and default_outcome(task, label, meaning) == command.outcome:
            edit.set_in(("root",), "on", label, command.to)


def _ends_of_root(root: AnyNode, outcome: str, led: bool) -> Mapping[str, str]:
    """Return the ends of the root that are known here: of a leaf its manifest, of a subtask its file knows more.

    Raises:
        EditError: it can't be told whether a leaf or a subtask ends with that very word.
    """
    if not isinstance(root, Leaf | Subtask):
        return outcomes_of(root)
    known = {**{label: label for label in STANDARD}, **root.meaning}
    if outcome not in known and not led:
        what = root.node if isinstance(root, Leaf) else root.task
        message = f"whether {what} ends with {outcome!r} isn't known here; connect that end of the root first"
        raise EditError("", message)
    return known


def _of_container(edit: Edit, command: RenameOutcome) -> None:
    node, place = edit.node(command.path), edit.place(command.path)
    edit.rekey((*place, "outcomes"), command.outcome, command.to)
    _inside(edit, node, place, command)
    if command.path == "/" or isinstance(edit.parent(command.path, "")[2], StateMachine):
        _follow_keys(edit, (*place, "on"), edit.entries(place, "on"), "", command)
    if command.path == "/":
        _at_root(edit, command)
    else:
        _around(edit, command)


def _inside(edit: Edit, node: AnyNode, place: Place, command: RenameOutcome) -> None:
    for key, label in edit.entries(place, "exits").items():
        if label == command.outcome:
            edit.set((*place, "exits"), key, command.to)
    for number, rule in enumerate(file_data(edit.draft.mapping(place).get("rules", []))):
        if rule.get("then") == command.outcome:
            edit.set((*place, "rules", str(number)), "then", command.to)
    if isinstance(node, StateMachine) and command.outcome not in node.children:
        for name, child in node.children.items():
            for label, target in child.on.items():
                if target == command.outcome:
                    edit.set((*place, "children", name, "on"), label, command.to)


def _at_root(edit: Edit, command: RenameOutcome) -> None:
    task = edit.task
    meaning = outcomes_of(task.root)[command.outcome]  # type: ignore[arg-type]
    target = default_outcome(task, command.outcome, meaning)
    if command.outcome in task.root.on or target in (None, default_outcome(task, command.to, meaning)):
        return
    edit.set_in(("root",), "on", command.to, target)


def _around(edit: Edit, command: RenameOutcome) -> None:
    above, name, _ = edit.parent(command.path, "")
    place = edit.place(above)
    _follow_keys(edit, (*place, "exits"), edit.entries(place, "exits"), f"{name}.", command)
    for number, rule in enumerate(file_data(edit.draft.mapping(place).get("rules", []))):
        said = rule.get("when", {}).get(name)
        if said is None:
            continue
        new = [_renamed(each, command) for each in said] if isinstance(said, list) else _renamed(said, command)
        if new != said:
            edit.set((*place, "rules", str(number), "when"), name, new)


def _follow_keys(edit: Edit, at: Place, entries: Mapping[str, object], start: str, command: RenameOutcome) -> None:
    """Rename the keys that begin with `start` and go on with the outcome, or with one of its codes."""
    for key in entries:
        if key.startswith(start):
            edit.rekey(at, key, start + _renamed(key.removeprefix(start), command))


def _renamed(label: str, command: RenameOutcome) -> str:
    outcome, dot, code = label.partition(".")
    return f"{command.to}{dot}{code}" if outcome == command.outcome else label
