"""Expressions: readable, over variables that are there, with parts that fit together."""

from __future__ import annotations

import ast

from grip_bt.base.errors import ExpressionError, listing, nearest
from grip_bt.base.expression import Expression, parse_expression
from grip_bt.task import expressions_of
from grip_bt.task.catalog import Type

from ..expression_types import ANY, type_of
from ..survey import Spot, Survey
from ..wording import take_hint

CONDITIONS = ("precondition", "if", "while")
"""Keys whose expression is true or false."""


def check_expressions(survey: Survey) -> None:
    """Find expressions that can't be read, unknown variables in them, and parts of wrong types."""
    for spot in survey.spots:
        if spot.plain:
            continue
        for key, text in expressions_of(spot.node):
            try:
                expression = parse_expression(text)
            except ExpressionError as error:
                survey.add(spot.path, key, "bad-expression", str(error))
                continue
            _names(survey, spot, key, expression)
            _types(survey, spot, key, expression)


def _names(survey: Survey, spot: Spot, key: str, expression: Expression) -> None:
    scope = spot.scope_of(key)
    for name in expression.names:
        if name not in scope:
            hint = nearest(name, scope)
            survey.add(
                spot.path,
                key,
                "undeclared-variable",
                f"`{expression.text}` reads {name!r}, which isn't declared{hint} (there are: {listing(scope)})",
                take_hint(hint, "declare it in `data` of an enclosing container; text is written in quotes"),
            )


def _types(survey: Survey, spot: Spot, key: str, expression: Expression) -> None:
    wrong: list[str] = []

    def note(part: ast.expr, reason: str) -> None:
        wrong.append(reason)
        survey.add(
            spot.path,
            key,
            "wrong-expression-type",
            f"`{expression.text}`, column {expression.column(part)}: {reason}",
        )

    scope = spot.scope_of(key)
    types: dict[str, Type] = {name: scope[name].type or ANY for name in expression.names if name in scope}
    given = type_of(expression, types, note)
    if key in CONDITIONS and given.name not in ("bool", "Any") and not wrong:
        survey.add(
            spot.path,
            key,
            "wrong-expression-type",
            f"`{expression.text}` gives a {given}; `{key}` has to be true or false",
            "compare it with something",
        )
