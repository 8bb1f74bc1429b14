"""Expressions of a task, computed by walking Python's own syntax tree of their text."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from typing import Any

_CONSTANTS = {"true": True, "false": False, "null": None}
_FUNCTIONS = {"len": len, "min": min, "max": max, "abs": abs}
_OPERATORS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.USub: operator.neg,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.In: lambda value, many: value in many,
    ast.NotIn: lambda value, many: value not in many,
}


def compute(text: str, read: Callable[[str], Any]) -> Any:
    """Return what an expression comes to.

    Args:
        text: the expression.
        read: returns a variable's value, or raises.
    """
    return _value(ast.parse(text.strip(), mode="eval").body, read)


def is_true(text: str, read: Callable[[str], Any]) -> bool:
    """Return whether a condition holds; what isn't true or false raises."""
    held = compute(text, read)
    if not isinstance(held, bool):
        raise TypeError(f"`{text}` is neither true nor false")
    return held


def _value(node: ast.expr, read: Callable[[str], Any]) -> Any:
    match node:
        case ast.Constant(value=value):
            return value
        case ast.Name(id=name):
            return _CONSTANTS[name] if name in _CONSTANTS else read(name)
        case ast.List(elts=items):
            return [_value(item, read) for item in items]
        case ast.BoolOp(op=op, values=values):
            return _joined(isinstance(op, ast.And), values, read)
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return not _truth(operand, read)
        case ast.UnaryOp(op=op, operand=operand):
            return _OPERATORS[type(op)](_value(operand, read))
        case ast.BinOp(left=left, op=op, right=right):
            return _OPERATORS[type(op)](_value(left, read), _value(right, read))
        case ast.Compare(left=left, ops=ops, comparators=others):
            return _compared(_value(left, read), ops, others, read)
        case ast.Call(func=ast.Name(id=name), args=arguments):
            return _FUNCTIONS[name](*(_value(argument, read) for argument in arguments))
    raise ValueError(f"no expression of a task: {ast.unparse(node)}")


def _truth(node: ast.expr, read: Callable[[str], Any]) -> bool:
    value = _value(node, read)
    if not isinstance(value, bool):
        raise TypeError(f"{ast.unparse(node)} is neither true nor false")
    return value


def _joined(every: bool, values: list[ast.expr], read: Callable[[str], Any]) -> bool:
    """Return `and` or `or` of conditions, of which those after the deciding one aren't looked at."""
    for value in values:
        if _truth(value, read) is not every:
            return not every
    return every


def _compared(left: Any, ops: list[ast.cmpop], others: list[ast.expr], read: Callable[[str], Any]) -> bool:
    for op, other in zip(ops, others, strict=True):
        right = _value(other, read)
        if not _OPERATORS[type(op)](left, right):
            return False
        left = right
    return True
