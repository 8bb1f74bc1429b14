"""Expressions computed, over the readers of their variables.

Every step checks what it works on, since a value's own operators could do anything: arithmetic is for numbers, `and or
not` for truth values. What can't be computed is an `EvaluationError`, which ends a run as a bug of the task.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Mapping
from numbers import Real
from typing import TypeVar

from grip_bt.base.errors import EvaluationError

from .expression import CONSTANTS, Expression

T = TypeVar("T")
Evaluator = Callable[[], object]
_ARITHMETIC: dict[type[ast.operator], tuple[str, Callable[..., object]]] = {
    ast.Add: ("+", operator.add),
    ast.Sub: ("-", operator.sub),
    ast.Mult: ("*", operator.mul),
    ast.Div: ("/", operator.truediv),
    ast.FloorDiv: ("//", operator.floordiv),
    ast.Mod: ("%", operator.mod),
}
_COMPARISONS: dict[type[ast.cmpop], Callable[..., object]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.In: lambda a, b: a in b,
    ast.NotIn: lambda a, b: a not in b,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
}
_FUNCTIONS: dict[str, Callable[..., object]] = {"len": len, "min": min, "max": max, "abs": abs}


def value_of(expression: Expression, readers: Mapping[str, Evaluator]) -> Evaluator:
    """Return a function that computes the expression, or raises EvaluationError where the values don't fit it.

    Args:
        readers: variable -> what returns its value; one for each of `expression.names`.
    """
    return _with_context(expression, lambda: _value(expression.tree, readers))


def condition_of(expression: Expression, readers: Mapping[str, Evaluator]) -> Callable[[], bool]:
    """Return a function that computes a condition; anything but a truth value is an EvaluationError."""
    return _with_context(expression, lambda: _truth(_value(expression.tree, readers)))


def _with_context(expression: Expression, compute: Callable[[], T]) -> Callable[[], T]:
    """Return `compute` with what it raises said in terms of the expression."""

    def value() -> T:
        try:
            return compute()
        except (TypeError, ValueError, ArithmeticError, AttributeError, RecursionError) as error:
            raise EvaluationError(expression.text, str(error)) from error

    return value


def same_literal(value: object, literal: object) -> bool:
    """Tell whether a value is a literal of a task file: 1 and 1.0 are the same, 1 and true aren't."""
    if _is_truth(value) or isinstance(literal, bool):
        return _is_truth(value) and isinstance(literal, bool) and bool(value) == literal
    if isinstance(value, Real) and isinstance(literal, Real):
        return bool(value == literal)
    return type(value) is type(literal) and bool(value == literal)


def _value(node: ast.expr, readers: Mapping[str, Evaluator]) -> object:
    match node:
        case ast.Constant(value=value):
            return value
        case ast.Name(id=name):
            return CONSTANTS[name] if name in CONSTANTS else readers[name]()
        case ast.Attribute(value=owner, attr=name):
            found = getattr(_value(owner, readers), name)
            if callable(found):
                raise TypeError(f"{name!r} is a method; an expression can't call it")
            return found
        case ast.List(elts=items) | ast.Tuple(elts=items):
            return [_value(item, readers) for item in items]
        case ast.BoolOp(op=op, values=values):
            terms = (_truth(_value(value, readers)) for value in values)
            return all(terms) if isinstance(op, ast.And) else any(terms)
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return not _truth(_value(operand, readers))
        case ast.UnaryOp(op=sign, operand=operand):
            minus = isinstance(sign, ast.USub)
            number = _number(_value(operand, readers), "-" if minus else "+")
            return -number if minus else +number
        case ast.BinOp(left=left, op=way, right=right):
            shown, function = _ARITHMETIC[type(way)]
            return function(*(_number(_value(side, readers), shown) for side in (left, right)))
        case ast.Compare(left=left, ops=ops, comparators=others):
            here = _value(left, readers)
            for comparison, other in zip(ops, others, strict=True):
                there = _value(other, readers)
                if not _truth(_COMPARISONS[type(comparison)](here, there)):
                    return False
                here = there
            return True
        case ast.Call(func=ast.Name(id=name), args=args):
            return _FUNCTIONS[name](*(_value(arg, readers) for arg in args))
    raise AssertionError(f"{type(node).__name__} passed the allow-list and has no meaning")


def _number(value: object, sign: str) -> Real:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise TypeError(f"`{sign}` needs numbers; got {_describe(value)}")
    return value


def _is_truth(value: object) -> bool:
    of_numpy = getattr(getattr(value, "dtype", None), "kind", "") == "b" and getattr(value, "ndim", None) == 0
    return isinstance(value, bool) or of_numpy


def _truth(value: object) -> bool:
    if not _is_truth(value):
        raise TypeError(f"a condition must be true or false; got {_describe(value)}")
    return bool(value)


def _describe(value: object) -> str:
    text = repr(value)
    return f"{text if len(text) <= 40 else text[:37] + '...'} ({type(value).__name__})"
