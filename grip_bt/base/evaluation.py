"""Expressions computed: compiled once to a closure over the readers of their variables.

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
    return _with_context(expression, _compile(expression.tree, readers))


def condition_of(expression: Expression, readers: Mapping[str, Evaluator]) -> Callable[[], bool]:
    """Return a function that computes a condition; anything but a truth value is an EvaluationError."""
    compute = _compile(expression.tree, readers)
    return _with_context(expression, lambda: _truth(compute()))


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


def _compile(node: ast.expr, readers: Mapping[str, Evaluator]) -> Evaluator:
    match node:
        case ast.Constant(value=value):
            return lambda: value
        case ast.Name(id=name):
            if name in CONSTANTS:
                constant = CONSTANTS[name]
                return lambda: constant
            return readers[name]
        case ast.Attribute(value=owner, attr=name):
            return _attribute(_compile(owner, readers), name)
        case ast.List(elts=items) | ast.Tuple(elts=items):
            parts = [_compile(item, readers) for item in items]
            return lambda: [part() for part in parts]
        case ast.BoolOp(op=op, values=values):
            terms = [_compile(value, readers) for value in values]
            if isinstance(op, ast.And):
                return lambda: all(_truth(term()) for term in terms)
            return lambda: any(_truth(term()) for term in terms)
        case ast.UnaryOp(op=sign, operand=operand):
            return _unary(sign, _compile(operand, readers))
        case ast.BinOp(left=left, op=way, right=right):
            return _arithmetic(way, _compile(left, readers), _compile(right, readers))
        case ast.Compare(left=left, ops=ops, comparators=others):
            steps = [(_COMPARISONS[type(op)], _compile(other, readers)) for op, other in zip(ops, others, strict=True)]
            return _comparison(_compile(left, readers), steps)
        case ast.Call(func=ast.Name(id=name), args=args):
            function, given = _FUNCTIONS[name], [_compile(arg, readers) for arg in args]
            return lambda: function(*(arg() for arg in given))
    raise AssertionError(f"{type(node).__name__} passed the allow-list and has no meaning")


def _attribute(owner: Evaluator, name: str) -> Evaluator:
    def value() -> object:
        found = getattr(owner(), name)
        if callable(found):
            raise TypeError(f"{name!r} is a method; an expression can't call it")
        return found

    return value


def _unary(sign: ast.unaryop, operand: Evaluator) -> Evaluator:
    if isinstance(sign, ast.Not):
        return lambda: not _truth(operand())
    if isinstance(sign, ast.USub):
        return lambda: -_number(operand(), "-")
    return lambda: +_number(operand(), "+")


def _arithmetic(way: ast.operator, left: Evaluator, right: Evaluator) -> Evaluator:
    sign, function = _ARITHMETIC[type(way)]
    return lambda: function(_number(left(), sign), _number(right(), sign))


def _comparison(first: Evaluator, steps: list[tuple[Callable[..., object], Evaluator]]) -> Evaluator:
    def value() -> bool:
        left = first()
        for compare, other in steps:
            right = other()
            if not _truth(compare(left, right)):
                return False
            left = right
        return True

    return value


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
