"""Copy and paste of a node with all below it: under a fresh name, with the variables that it shares with others."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import count
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from grip_bt.base.frozen import FrozenDict

from ..canonical import file_data
from ..model import AnyNode, Name, Sequence, StateMachine, Task, children_of, outcomes_of, walk
from .editing import BaseCommand, Edit, expect_free, expect_room, path_in_words, slot
from .variables import RenameVariable, declared_by, used_by


class Clip(BaseModel):
    """A copy of a node: what `clip_of` returns, a clipboard holds and `paste` takes."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    name: Name
    node: FrozenDict[str, object]
    """The node as it stands in a file, with whatever is below it."""
    variables: FrozenDict[Name, object] = FrozenDict()
    """The declarations of the variables that it uses and that are declared around it."""


class Paste(BaseCommand):
    """A copy of a node goes into a container, of this task or of another one.

    Its name gets a number where it is taken. A variable that it uses is the one of that name and type that is seen
    there; where there is none, it is declared in the container, under a fresh name where the name means something
    else. Edges that lead to nothing there are left out.
    """

    do: Literal["paste"] = "paste"
    parent: str
    clip: Clip
    name: Name | None = None
    index: int | None = Field(default=None, ge=0)
    """Position among the children; None: after the last."""
    variables: Literal["share", "fresh"] = "share"
    """`fresh`: its own variables, even where there are ones of their names and types."""

    def in_words(self) -> str:
        return f"paste {self.name or self.clip.name} into {path_in_words(self.parent)}"

    def plan(self, edit: Edit) -> None:
        parent, clip = edit.container(self.parent), self.clip
        expect_room(parent, self.parent)
        if self.name is not None:
            expect_free(parent, self.parent, self.name)
        name = self.name or fresh_name(clip.name, {*children_of(parent), *_outcomes(parent)})
        there = _seen_from(edit.task, self.parent, itself=True)
        names = _names(self, there)
        node = _with_names(clip, names)
        place = edit.place(self.parent)
        for old, declaration in clip.variables.items():
            if names[old] not in there:
                edit.set_in(place, "data", names[old], file_data(declaration))
        on = node.pop("on", None)
        if isinstance(on, dict) and isinstance(parent, StateMachine):
            kept = {k: v for k, v in on.items() if v in children_of(parent) or v in _outcomes(parent)}
            node |= {"on": kept} if kept else {}
        edit.put((*place, slot(parent)), name, node, self.index)


def clip_of(task: Task, path: str) -> Clip:
    """Return a node with all below it, and the declarations of the variables that it uses and doesn't declare itself.

    Raises:
        EditError: there is no such node.
    """
    node = Edit(task).node(path)
    used = _free(node)
    variables = {name: declared for name, declared in _seen_from(task, path).items() if name in used}
    name = path.rpartition("/")[2] or "root"
    return Clip(name=name, node=file_data(node), variables=file_data(variables))


def _names(command: Paste, there: Mapping[str, object]) -> dict[str, str]:
    names: dict[str, str] = {}
    inside = (name for _, node in walk(_parsed(command.clip).root) for name in declared_by(node))
    taken = {*there, *command.clip.variables, *inside}
    for name, declaration in command.clip.variables.items():
        alike = name in there and _type(there[name]) == _type(declaration)
        if alike and command.variables == "share":
            names[name] = name
        else:
            names[name] = name if name not in there else fresh_name(name, taken)
            taken.add(names[name])
    return names


def _with_names(clip: Clip, names: Mapping[str, str]) -> dict[str, object]:
    task = _parsed(clip)
    for old, new in names.items():
        if new != old:
            edit = Edit(task)
            RenameVariable(path="", name=old, to=new).plan(edit)
            task = edit.draft.task(clip.name)
    node = file_data(children_of(task.root)[clip.name])
    assert isinstance(node, dict)
    return node


def _parsed(clip: Clip) -> Task:
    data: dict[str, object] = {"grip": 1, "name": "clip", "data": file_data(clip.variables)}
    edit = Edit(Task.model_validate({**data, "root": {"kind": Sequence.kind_name(), "children": {}}}))
    edit.put(("root", "children"), clip.name, file_data(clip.node))
    return edit.draft.task(clip.name)


def fresh_name(name: str, taken: set[str]) -> str:
    """Return the name, or the name with the first number with which it isn't taken."""
    if name not in taken:
        return name
    head, _, tail = name.rpartition("_")
    stem = head if head and tail.isdecimal() else name
    return next(each for number in count(2) if (each := f"{stem}_{number}") not in taken)


def _outcomes(container: AnyNode) -> set[str]:
    return set(outcomes_of(container)) if isinstance(container, StateMachine) else set()


def _free(node: AnyNode) -> set[str]:
    around, inside = used_by(node)
    below = set().union(*(_free(child) for child in children_of(node).values()))
    return around | ((inside | below) - set(declared_by(node)))


def _seen_from(task: Task, path: str, itself: bool = False) -> dict[str, object]:
    """Return name -> declaration of the variables around a node, or those that its children see."""
    seen: dict[str, object] = dict(task.data)
    node, names = task.root, [] if path == "/" else path.split("/")
    for name in names:
        _declare(seen, node)
        node = children_of(node)[name]
    if itself:
        _declare(seen, node)
    return seen


def _declare(seen: dict[str, object], node: AnyNode) -> None:
    seen.update(dict.fromkeys(declared_by(node), "Any"))
    seen.update(getattr(node, "data", {}))


def _type(declaration: object) -> str:
    return declaration if isinstance(declaration, str) else str(file_data(declaration)["type"])
