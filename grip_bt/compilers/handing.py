"""How values go into a subtask when it is entered, and out of it when it ends."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any

from grip_bt.base.errors import NodeError
from grip_bt.task import model

from .resolve import Part
from .scopes import UNSET, Cell, Scope, Scopes

_Move = tuple[Callable[[], Any], Callable[[Any], None]]


def hand_in(part: Part, scopes: Scopes) -> Callable[[], None]:
    """Return what begins the variables of a subtask anew and gives it its inputs."""
    node = part.node
    assert isinstance(node, model.Subtask), "only these have ports of their own file"
    moves: list[_Move] = []
    for port, variable in node.in_.items():
        read = scopes.reader(part.path, port, _cell(part.around, variable))
        moves.append((read, scopes.writer(part.path, port, _cell(part.scope, port))))
    for port, literal in node.with_.items():
        moves.append((_copies(literal), scopes.writer(part.path, port, _cell(part.scope, port))))

    def enter() -> None:
        part.scope.reset()
        _carry_out(part.path, moves)

    return enter


def hand_out(part: Part, scopes: Scopes) -> Callable[[], None]:
    """Return what gives the outputs of a subtask to the variables around it; an output that wasn't made is none."""
    node = part.node
    assert isinstance(node, model.Subtask), "only these have ports of their own file"
    bound = [
        (_cell(part.scope, port), scopes.writer(part.path, port, _cell(part.around, variable)))
        for port, variable in node.out.items()
    ]

    def leave() -> None:
        _carry_out(part.path, [(_value(cell), write) for cell, write in bound if cell.value is not UNSET])

    return leave


def _carry_out(path: str, moves: list[_Move]) -> None:
    try:
        for read, write in moves:
            write(read())
    except Exception as error:
        raise NodeError(path, error) from error


def _value(cell: Cell) -> Callable[[], Any]:
    return lambda: cell.value


def _copies(literal: Any) -> Callable[[], Any]:
    return lambda: deepcopy(literal)


def _cell(scope: Scope, variable: str) -> Cell:
    cell = scope.find(variable)
    assert cell is not None, "resolved variables are declared"
    return cell
