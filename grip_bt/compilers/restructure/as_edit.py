"""A conversion as an edit: steps on the document, which keep the comments of all that stays and can be undone."""

from __future__ import annotations

from typing import Any

from grip_bt.base.errors import EditError, InvalidTaskError
from grip_bt.compilers.restructure.conversion import to_state_machines, to_trees
from grip_bt.task import dumps, loads
from grip_bt.task.canonical import data_of, file_data
from grip_bt.task.catalog import Catalog
from grip_bt.task.document import CHILDREN
from grip_bt.task.edit import (
    AnyCommand,
    ChangeKind,
    Convert,
    Disconnect,
    Group,
    Patch,
    apply,
    path_after,
    title_of,
)
from grip_bt.task.edit.documents import differences
from grip_bt.task.edit.editing import Draft
from grip_bt.task.edit.steps import Place, Put, Rekey, Shift, Step
from grip_bt.task.model import KINDS, Leaf, StateMachine, Task, children_of, join, walk

from .result import Restructured

STANDARD = frozenset(("success", "failure"))


def expanded(command: AnyCommand, task: Task, catalog: Catalog) -> AnyCommand:
    """Return a command in which every `convert` is the edit that it comes to, for whoever applies it.

    A `change_kind` gives leaves edges for the outcomes that they have.

    Raises:
        EditError: what is to be converted has no equal in the other form, or the task isn't right.
    """
    if isinstance(command, Convert):
        return _conversion(command, task, catalog)
    if isinstance(command, ChangeKind):
        return _with_own_edges(command, task, catalog)
    if isinstance(command, Group):
        parts: list[AnyCommand] = []
        for part in command.commands:  # a group's own commands say which edges go
            parts.append(part if isinstance(part, ChangeKind) else expanded(part, task, catalog))
            task = apply(task, parts[-1]).task
        return command.model_copy(update={"commands": tuple(parts)})
    return command


def _with_own_edges(command: ChangeKind, task: Task, catalog: Catalog) -> AnyCommand:
    """Return a change of kind that gives leaves no edge for an outcome that they never end with."""
    before = dict(walk(task.root)).get(command.path)
    kind = KINDS.get(command.kind)
    if kind is None or not kind.by_edges or before is None or isinstance(before, StateMachine):
        return command
    gone = [
        Disconnect(path=join(command.path, name), outcome=outcome)
        for name, child in children_of(before).items()
        if isinstance(child, Leaf) and child.node in catalog
        for outcome in sorted(STANDARD - catalog.get(child.node).outcomes.keys())
    ]
    return Group(title=title_of(command), commands=(command, *gone)) if gone else command


def _conversion(command: Convert, task: Task, catalog: Catalog) -> Patch:
    if command.path not in {path for path, _ in walk(task.root)}:
        raise EditError(command.path, "there is no such node")
    try:
        convert = to_state_machines if command.to == "sm" else to_trees
        result = convert(task, catalog, command.path)
    except InvalidTaskError as error:
        raise EditError(command.path, f"only a task without errors is converted: {error.issues[0]}") from None
    if result.task == task:
        why = "; ".join(str(note) for note in result.notes if not note.by_design) or "it has that form already"
        raise EditError(command.path, why)
    moving = _Moving(task, result)  # nodes are moved, not written anew
    target = file_data(data_of(loads(dumps(result.task))))  # as a file says it: nothing that only repeats a default
    moving.settle(target["root"], "/", ("root",))
    steps = (*moving.steps, *differences(file_data(moving.draft.mapping(())), target))
    return Patch(title=title_of(command), steps=steps)


class _Moving:
    def __init__(self, task: Task, result: Restructured):
        self.draft = Draft(task)
        self.origin = {new: old for old, new in result.paths.items()}
        self.steps: list[Step] = []

    def take(self, step: Step) -> None:
        self.draft.apply(step)
        self.steps.append(step)

    def settle(self, node: dict[str, Any], path: str, place: Place) -> None:
        """Bring every old node below a new one to where it shall be, into containers that are made for it."""
        for key in CHILDREN:
            if key not in node:
                continue
            if key not in self.draft.mapping(place):
                self.take(Put(at=place, key=key, value={}))
            for index, (name, child) in enumerate(node[key].items()):
                self.child(child, join(path, name), (*place, key), name, index)

    def child(self, node: dict[str, Any], path: str, at: Place, name: str, index: int) -> None:
        old = self.origin.get(path)
        if old is None:
            empty = {key: {} if key in CHILDREN else value for key, value in node.items()}
            self.take(Put(at=at, key=name, value=empty, index=index))
        else:
            now = path_after(old, self.steps)
            assert now is not None, "nothing is taken out before the end"
            if now != path:
                *above, last = self.place(now)
                self.take(Shift(at=tuple(above), key=last, to=at, index=index))
                if last != name:
                    self.take(Rekey(at=at, key=last, to=name))
        self.settle(node, path, (*at, name))

    def place(self, path: str) -> Place:
        place: Place = ("root",)
        for name in path.split("/") if path != "/" else ():
            inside = self.draft.mapping(place)
            key = next(k for k in CHILDREN if k in inside and name in self.draft.mapping((*place, k)))
            place = (*place, key, name)
        return place
