"""What a kind asks, bound to the variables of its scope: conditions, values, and variables that it reads and writes."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from grip_bt.base.evaluation import condition_of, value_of
from grip_bt.base.expression import Expression, parse_expression
from grip_bt.compilers.scopes import Cell, Scope, Scopes
from grip_bt.nodes.answers import Answers
from grip_bt.nodes.control import Condition
from grip_bt.task.model import Kind

if TYPE_CHECKING:
    from grip_bt.compilers.resolve import Part


def bind_condition(path: str, key: str, text: str, scope: Scope, scopes: Scopes) -> Condition:
    """Return the condition at `key` of the node at `path`."""
    expression, cells = _cells(text, scope)
    readers = {name: scopes.reader(path, key, cell) for name, cell in cells.items()}

    def watch(written: Callable[[], None]) -> None:
        for cell in cells.values():
            cell.watchers.append(written)

    return Condition(expression.text, condition_of(expression, readers), watch)


def answers_of(part: Part, scopes: Scopes) -> Answers:
    """Return the answers of a run to the kind of a container."""
    assert isinstance(part.node, Kind), "leaves ask nothing"
    answers = Answers(part.path, [child.name for child in part.children], part.exits, part.edges)
    bind_answers(answers, part, part.node, scopes)
    return answers


def bind_answers(answers: Answers, part: Part, kind: Kind, scopes: Scopes) -> None:
    """Bind answers to the cells of the variables that a kind asks for."""
    path, scope = part.path, part.scope
    for key, text in kind.expressions():
        field = next(name for name in (*kind.conditions, *kind.values) if name.rstrip("_") == key)
        if field in kind.conditions:
            answers.conditions[field] = bind_condition(path, key, text, scope, scopes).holds
        else:
            answers.readers[field] = bind_value(path, key, text, scope, scopes)
    for key in kind.reads:
        answers.readers[key] = scopes.reader(path, key, _cell(scope, getattr(kind, key)))
    for key in kind.puts:
        answers.writers[key] = scopes.writer(path, key, _cell(scope, getattr(kind, key)))


def bind_value(path: str, key: str, text: str, scope: Scope, scopes: Scopes) -> Callable[[], Any]:
    """Return what computes the expression at `key` of the node at `path`."""
    expression, cells = _cells(text, scope)
    return value_of(expression, {name: scopes.reader(path, key, cell) for name, cell in cells.items()})


def _cells(text: str, scope: Scope) -> tuple[Expression, dict[str, Cell]]:
    expression = parse_expression(text)
    cells: dict[str, Cell] = {}
    for name in expression.names:
        cells[name] = _cell(scope, name)
    return expression, cells


def _cell(scope: Scope, name: str) -> Cell:
    cell = scope.find(name)
    assert cell is not None, "resolved variables are declared"
    return cell
