"""Python expressions as they are laid out in a generated file: one line where it fits, else one item a line."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from grip_bt.base.python_literals import py

WIDTH = 88
"""Longest line, as formatters have it by default."""
_STEP = 4


@dataclass(frozen=True)
class Raw:
    """Text that is Python already: a name, a lambda; never a value of a task."""

    text: str


@dataclass(frozen=True)
class Bracketed:
    """Something between brackets, which `before` and `after` end with and are; items with what stands before each."""

    before: str
    items: tuple[tuple[str, Expr], ...]
    after: str


Expr = Raw | Bracketed


def call(function: str, /, *given: object, **named: object) -> Bracketed:
    """Return a call; arguments are expressions, or values that are written as literals."""
    items = [("", literal(value)) for value in given]
    items += [(f"{name}=", literal(value)) for name, value in named.items()]
    return Bracketed(f"{function}(", tuple(items), ")")


def literal(value: object) -> Expr:
    """Return the expression of a value; expressions in it stay as they are. Raises TypeError: it isn't a literal."""
    if isinstance(value, Raw | Bracketed):
        return value
    if isinstance(value, float) and not math.isfinite(value):
        return Raw(f"float({py(str(value))})")
    if isinstance(value, Mapping):
        return Bracketed("{", tuple((f"{flat(literal(k))}: ", literal(v)) for k, v in value.items()), "}")
    if isinstance(value, list | tuple):
        return Bracketed("[", tuple(("", literal(item)) for item in value), "]")
    return Raw(py(value))


def flat(expression: Expr) -> str:
    """Return an expression on one line."""
    if isinstance(expression, Raw):
        return expression.text
    return expression.before + ", ".join(b + flat(item) for b, item in expression.items) + expression.after


def format_expression(expression: Expr, indent: int, column: int, tail: int = 0) -> str:
    """Return an expression as it is written.

    Args:
        indent: of the statement [columns].
        column: where it begins.
        tail: columns that follow on its last line.
    """
    line = flat(expression)
    if isinstance(expression, Raw) or not expression.items or column + len(line) + tail <= WIDTH:
        return line
    inner = indent + _STEP
    parts = ((before, format_expression(item, inner, inner + len(before), 1)) for before, item in expression.items)
    lines = (f"{' ' * inner}{before}{text},\n" for before, text in parts)
    return f"{expression.before}\n{''.join(lines)}{' ' * indent}{expression.after}"


def statement(target: str, expression: Expr, indent: int = _STEP) -> str:
    """Return `target = expression`, indented; no target makes it the expression alone."""
    before = f"{' ' * indent}{target} = " if target else " " * indent
    return before + format_expression(expression, indent, len(before))


def remarked(text: str, remark: str, indent: int = _STEP) -> str:
    """Return a statement with a remark: behind it where it fits, else above it."""
    behind = f"{text}  {comment(remark)}"
    return behind if len(behind) <= WIDTH and "\n" not in behind else f"{comment(remark, indent)}\n{text}"


def comment(text: str, indent: int = 0) -> str:
    """Return text of any kind as comment lines; empty for an empty text."""
    words = "".join(c if c.isprintable() else " " for c in text).split()
    lines: list[str] = []
    for word in words:
        if lines and len(lines[-1]) + 1 + len(word) <= WIDTH:
            lines[-1] += f" {word}"
        else:
            lines.append(f"{' ' * indent}# {word}")
    return "\n".join(lines)
