"""Commands on variables; bindings and expressions in their scope follow."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Literal

from pydantic import Field

from grip_bt.base.errors import EditError, ExpressionError, listing, nearest
from grip_bt.base.expression import parse_expression

from ..canonical import file_data
from ..document import DECLARING
from ..model import AnyNode, Name, Variable, children_of, expressions_of, join
from .editing import Edit, PathCommand

_READS = ("items",)
"""Keys of containers that hold the name of a variable."""

_DECLARES = ("item",)
"""Keys of containers that declare a variable besides those in `data`."""


class Declare(PathCommand):
    """A new variable of a container, or (with an empty path) of the task."""

    do: Literal["declare"] = "declare"
    words: ClassVar[str] = "declare {name} in {path}"
    name: Name
    variable: Variable | str
    index: int | None = Field(default=None, ge=0)

    def plan(self, edit: Edit) -> None:
        holder = _holder(edit, self.path)
        if self.name in declared_by(holder):
            raise EditError(self.path, f"the variable {self.name!r} already exists")
        place = edit.place(self.path)
        value = file_data(self.variable)
        if "data" in edit.draft.mapping(place):
            edit.put((*place, "data"), self.name, value, self.index)
        else:
            edit.put(place, "data", {self.name: value})


class Undeclare(PathCommand):
    """A variable goes; nothing may use it any more."""

    do: Literal["undeclare"] = "undeclare"
    words: ClassVar[str] = "remove the variable {name} of {path}"
    name: str

    def plan(self, edit: Edit) -> None:
        _declared(edit, self.path, self.name)
        users = [viewer.path for viewer in _users(edit, self.path, self.name)]
        if users:
            shown = listing(dict.fromkeys(users))
            raise EditError(self.path, f"the variable {self.name!r} is used by {shown}; unbind it there first")
        holder, place = _holder(edit, self.path), edit.place(self.path)
        keys = [key for key in DECLARING if self.name in getattr(holder, key, ())]
        if not keys:
            raise EditError(self.path, f"the variable {self.name!r} belongs to the container's kind and stays")
        for key in keys:
            edit.drop_in(place, key, self.name)


class RenameVariable(PathCommand):
    """A variable is called `to`; the bindings and expressions that see it follow."""

    do: Literal["rename_variable"] = "rename_variable"
    words: ClassVar[str] = "rename the variable {name} to {to}"
    name: str
    to: Name

    def plan(self, edit: Edit) -> None:
        holder = _declared(edit, self.path, self.name)
        if self.to == self.name:
            return
        if self.to in declared_by(holder):
            raise EditError(self.path, f"there is a variable {self.to!r} already")
        _refuse_capture(edit, self)
        for viewer in list(_users(edit, self.path, self.name)):
            _follow(edit, viewer, self)
        place = edit.place(self.path)
        for key in DECLARING:
            if self.name in getattr(holder, key, ()):
                edit.rekey((*place, key), self.name, self.to)
        for key in _DECLARES:
            if getattr(holder, key, None) == self.name:
                edit.set(place, key, self.to)


def declared_by(holder: object) -> list[str]:
    """Return the variables that a task or a node declares."""
    own = [getattr(holder, key) for key in _DECLARES if hasattr(holder, key)]
    ports = [*getattr(holder, "inputs", ()), *getattr(holder, "outputs", ())]
    return list(dict.fromkeys([*ports, *getattr(holder, "data", ()), *own]))


def used_by(node: AnyNode) -> tuple[set[str], set[str]]:
    """Return the variables that a node itself uses: of those around it, and of those that it may declare too."""
    return _Viewer("", node, True, False).uses(), _Viewer("", node, False, True).uses()


def _holder(edit: Edit, path: str) -> object:
    return edit.task if path == "" else edit.container(path)


def _declared(edit: Edit, path: str, name: str) -> object:
    holder = _holder(edit, path)
    there = declared_by(holder)
    if name not in there:
        raise EditError(
            path, f"no variable {name!r} is declared here{nearest(name, there)} (available: {listing(there)})"
        )
    return holder


@dataclass(frozen=True)
class _Viewer:
    """A node from which a variable may be seen.

    `around` tells whether it is seen around the node (by its `precondition`), `inside` whether by what is its own.
    """

    path: str
    node: AnyNode
    around: bool
    inside: bool

    def uses(self) -> set[str]:
        node = self.node
        used: set[str] = {*getattr(node, "in_", {}).values(), *getattr(node, "out", {}).values()}
        if self.inside:
            used |= {getattr(node, key) for key in _READS if hasattr(node, key)}
        return used.union(*(_names(text) for _, text in self.expressions()))

    def expressions(self) -> Iterator[tuple[str, str]]:
        for key, text in expressions_of(self.node):
            if self.around if key == "precondition" else self.inside:
                yield key, text


def _users(edit: Edit, path: str, name: str) -> Iterator[_Viewer]:
    return (viewer for viewer in _scope(edit, path, name) if name in viewer.uses())


def _scope(edit: Edit, path: str, name: str) -> Iterator[_Viewer]:
    stack = [("/", edit.task.root)]
    if path != "":
        holder = edit.node(path)
        yield _Viewer(path, holder, False, True)
        stack = [(join(path, child), node) for child, node in children_of(holder).items()]
    while stack:
        inner, node = stack.pop()
        hidden = name in declared_by(node)
        yield _Viewer(inner, node, True, not hidden)
        if not hidden:
            stack.extend((join(inner, child), below) for child, below in children_of(node).items())


def _names(text: str) -> tuple[str, ...]:
    try:
        return parse_expression(text).names
    except ExpressionError:
        return ()


def _refuse_capture(edit: Edit, command: RenameVariable) -> None:
    """Refuse a name that means something else where the variable is used, or that is used in its scope."""
    for viewer in _scope(edit, command.path, command.name):
        if command.to in viewer.uses():
            raise EditError(
                command.path, f"{viewer.path} uses another variable {command.to!r}, which this one would hide"
            )
    for viewer in _users(edit, command.path, command.name):
        at = viewer.path
        while at != command.path:
            if command.to in declared_by(edit.node(at)):
                raise EditError(command.path, f"{at} has its own variable {command.to!r}, which would hide this one")
            at = "" if at == "/" else at.rpartition("/")[0] or "/"


def _follow(edit: Edit, viewer: _Viewer, command: RenameVariable) -> None:
    place = edit.place(viewer.path)
    for side in ("in", "out"):
        for port, variable in edit.entries(place, side).items():
            if variable == command.name:
                edit.set((*place, side), port, command.to)
    for key in _READS:
        if viewer.inside and getattr(viewer.node, key, None) == command.name:
            edit.set(place, key, command.to)
    for key, text in viewer.expressions():
        new = _renamed(text, command, viewer.path)
        if new == text:
            continue
        if not isinstance(edit.draft.mapping(place).get(key), str):
            message = f"the expression {text!r} under {key!r} can't be followed; change it by hand, then rename"
            raise EditError(viewer.path, message)
        edit.set(place, key, new)


def _renamed(text: str, command: RenameVariable, path: str) -> str:
    """Return an expression in which one variable has another name, and everything else stays as it is written."""
    if command.name not in _names(text):
        return text
    if not command.to.isidentifier():
        raise EditError(path, f"{command.to!r} can't be written in the expression {text!r}; choose letters, digits, _")
    data = text.strip().encode()
    found = [
        node.col_offset
        for node in ast.walk(parse_expression(text).tree)
        if isinstance(node, ast.Name) and node.id == command.name
    ]
    for start in sorted(found, reverse=True):
        data = data[:start] + command.to.encode() + data[start + len(command.name.encode()) :]
    return data.decode()
