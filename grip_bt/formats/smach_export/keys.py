"""Which variables of a task a container of SMACH passes in and out, as keys of its userdata."""

from __future__ import annotations

from collections.abc import Iterator

from grip_bt.base.expression import parse_expression
from grip_bt.compilers.resolve import Part
from grip_bt.compilers.scopes import Cell, Scope
from grip_bt.task import model, walking


def reads(part: Part) -> dict[str, Cell]:
    """Return the variables around a node that it, or something below it, reads."""
    return _outside(part, _read(part))


def writes(part: Part) -> dict[str, Cell]:
    """Return the variables around a node that it, or something below it, writes."""
    return _outside(part, _written(part))


def shares(part: Part) -> bool:
    """Tell whether a child of a parallel writes what a sibling of it reads or writes."""
    for child in part.children:
        mine = {id(cell) for cell in writes(child).values()}
        for other in part.children:
            theirs = {**reads(other), **writes(other)}
            if other is not child and mine & {id(cell) for cell in theirs.values()}:
                return True
    return False


def _outside(part: Part, used: Iterator[tuple[Scope, str]]) -> dict[str, Cell]:
    own = {id(cell) for below in part.walk() if below.declares for cell in below.scope.cells.values()}
    found: dict[str, Cell] = {}
    for scope, name in used:
        cell = scope.find(name)
        if cell is not None and id(cell) not in own:
            found[name] = cell
    return found


def _read(part: Part) -> Iterator[tuple[Scope, str]]:
    for below in part.walk():
        node = below.node
        for key, text in walking.expressions_of(node):
            scope = below.around if key == "precondition" else below.scope
            yield from ((scope, name) for name in parse_expression(text).names)
        if isinstance(node, model.Leaf | model.Subtask):
            yield from ((below.around, name) for name in node.in_.values())
        if isinstance(node, model.ForEach):
            yield below.scope, node.items


def _written(part: Part) -> Iterator[tuple[Scope, str]]:
    for below in part.walk():
        if isinstance(below.node, model.Leaf | model.Subtask):
            yield from ((below.around, name) for name in below.node.out.values())
