"""What a kind asks, bound to the variables of its scope: conditions, values, and variables that it reads and writes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from grip_bt.base.errors import ExpressionError, UnknownNameError
from grip_bt.base.evaluation import condition_of, value_of
from grip_bt.base.expression import Expression, parse_expression
from grip_bt.compilers.resolve import Part, Resolved
from grip_bt.compilers.scopes import Scope, Scopes
from grip_bt.nodes.answers import Answers
from grip_bt.nodes.condition import Condition
from grip_bt.task.model import Kind


def bind_condition(path: str, key: str, text: str, scope: Scope, scopes: Scopes) -> Condition:
    """Return the condition at `key` of the node at `path`."""
    expression = parse_expression(text)

    def watch(written: Callable[[], None]) -> None:
        for name in expression.names:
            scope.cell(name).watchers.append(written)

    return Condition(expression.text, condition_of(expression, _readers(path, key, expression, scope, scopes)), watch)


def _readers(path: str, key: str, expression: Expression, scope: Scope, scopes: Scopes) -> dict[str, Callable[[], Any]]:
    return {name: scopes.reader(path, key, scope.cell(name)) for name in expression.names}


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
            condition = bind_condition(path, key, text, scope, scopes)
            answers.conditions[field] = condition.holds
            if kind.reactive:
                condition.watch(answers.written)
        else:
            expression = parse_expression(text)
            answers.readers[field] = value_of(expression, _readers(path, key, expression, scope, scopes))
    for key in kind.reads:
        answers.readers[key] = scopes.reader(path, key, scope.cell(getattr(kind, key)))
    for key in kind.puts:
        answers.writers[key] = scopes.writer(path, key, scope.cell(getattr(kind, key)))


class Compiled(Protocol):
    """A compiled task, tree or machine."""

    data: Scopes
    _resolved: Resolved


def parts_of(compiled: Compiled) -> Mapping[str, Part]:
    """Return every node of a compiled task by path, in document order."""
    return {part.path: part for part in compiled._resolved.root.walk()}


def probe(compiled: Compiled, part: Part, text: str) -> Callable[[], bool]:
    """Return what computes a condition over the variables that a node sees.

    Raises:
        ExpressionError: the text isn't a condition.
        UnknownNameError: it names a variable that isn't declared there or above.
    """
    if not text.strip():
        raise ExpressionError(text, "a condition is missing, such as `count > 3`")
    for name in parse_expression(text).names:
        if part.scope.find(name) is None:
            raise UnknownNameError("variable", name, part.scope.visible(), f"`{text}` at {part.path}")
    return bind_condition(part.path, "if", text, part.scope, compiled.data).holds
