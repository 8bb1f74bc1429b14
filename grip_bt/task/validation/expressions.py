"""Expressions: what they read, and the types of what they give."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from functools import cache

from grip_bt.base.errors import ExpressionError, listing, nearest
from grip_bt.base.expression import CONSTANTS, Expression, parse_expression
from grip_bt.base.types import VALUES
from grip_bt.task import Leaf, expressions_of
from grip_bt.task.catalog import Type, is_assignable

from .analysis import PlacedNode, TaskAnalysis, type_or_none

BOOL, INT, FLOAT, ANY = Type("bool"), Type("int"), Type("float"), Type("Any")
_NUMBERS = ("int", "float", "Any")
_SIZED = ("str", "bytes", "list", "dict", "Any")
_ORDER = ast.Lt | ast.LtE | ast.Gt | ast.GtE

Note = Callable[[ast.expr, str], None]
"""Called with a part of an expression that doesn't fit, and why."""


def type_of(expression: Expression, types: Mapping[str, Type], note: Note) -> Type:
    """Return the type of what an expression gives; `types` are those of its variables."""
    return _Typing(types, note).of(expression.tree)


class _Typing:
    def __init__(self, types: Mapping[str, Type], note: Note):
        self.types, self.note = types, note

    def of(self, node: ast.expr) -> Type:
        match node:
            case ast.Constant(value=value):
                return Type("None") if value is None else Type(type(value).__name__)
            case ast.Name(id=name):
                if name in CONSTANTS:
                    return Type("None") if CONSTANTS[name] is None else BOOL
                return self.types.get(name, ANY)
            case ast.Attribute():
                return self.attribute(node)
            case ast.List(elts=items) | ast.Tuple(elts=items):
                return Type("list", _common([self.of(item) for item in items]))
            case ast.BoolOp(values=values):
                for term in values:
                    self.truth(term)
                return BOOL
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                self.truth(operand)
                return BOOL
            case ast.UnaryOp(operand=operand):
                return self.number(operand)
            case ast.BinOp(left=left, op=way, right=right):
                kinds = [self.number(left), self.number(right)]
                return FLOAT if isinstance(way, ast.Div) else _common(kinds)
            case ast.Compare():
                self.comparison(node)
                return BOOL
            case ast.Call(func=ast.Name(id=name), args=args):
                return self.call(name, args)
        return ANY

    def truth(self, node: ast.expr) -> None:
        kind = self.of(node)
        if kind.name not in ("bool", "Any"):
            self.note(node, f"`{ast.unparse(node)}` is a {kind}, not true or false; compare it with something")

    def number(self, node: ast.expr) -> Type:
        kind = self.of(node)
        if kind.name not in _NUMBERS:
            self.note(node, f"`{ast.unparse(node)}` is a {kind}, not a number")
            return ANY
        return kind

    def attribute(self, node: ast.Attribute) -> Type:
        owner = self.of(node.value)
        if owner.name not in VALUES:
            if owner.name in (*_SIZED[:3], "int", "float", "bool", "None"):
                self.note(node, f"`{ast.unparse(node.value)}` is a {owner}, which has no attributes")
            return ANY
        there = _attributes(owner.name)
        if node.attr not in there:
            hint = nearest(node.attr, there)
            self.note(node, f"a {owner.name} has no attribute {node.attr!r}{hint} (available: {listing(there)})")
        return there.get(node.attr, ANY)

    def comparison(self, node: ast.Compare) -> None:
        left = node.left
        for op, right in zip(node.ops, node.comparators, strict=True):
            one, other = self.of(left), self.of(right)
            if isinstance(op, ast.In | ast.NotIn):
                if other.name not in _SIZED:
                    self.note(right, f"`{ast.unparse(right)}` is a {other}, which nothing can be in")
            elif not isinstance(op, ast.Is | ast.IsNot) and not _comparable(one, other, isinstance(op, _ORDER)):
                self.note(left, f"a {one} can't be compared with a {other} by this operator")
            left = right

    def call(self, name: str, args: list[ast.expr]) -> Type:
        if name == "abs":
            return self.number(args[0])
        kinds = [self.of(arg) for arg in args]
        if name == "len":
            if kinds[0].name in ("int", "float", "bool", "None"):
                self.note(args[0], f"`{ast.unparse(args[0])}` is a {kinds[0]}, which has no length")
            return INT
        if len(args) > 1:
            return _common(kinds)
        if kinds[0].name not in ("list", "str", "Any"):
            self.note(args[0], f"`{ast.unparse(args[0])}` is a {kinds[0]}; {name}() takes a list, or several values")
        return kinds[0].item or ANY


def _common(kinds: list[Type]) -> Type:
    for kind in kinds:
        if all(is_assignable(other, kind) for other in kinds) and kind.name != "Any":
            return kind
    return ANY


def _comparable(one: Type, other: Type, ordered: bool) -> bool:
    names = {one.name, other.name}
    if "Any" in names or (not ordered and ("None" in names or one.optional or other.optional)):
        return True
    if names <= {"int", "float"}:
        return True
    return len(names) == 1 and not (ordered and names <= {"bool", "dict", "None", *VALUES})


@cache
def _attributes(value: str) -> dict[str, Type]:
    """Return the public attributes of a value's class, with their types as far as tasks have such types."""
    from grip_bt.base import values  # needs NumPy, which only such an expression has to wait for

    found: dict[str, Type] = {}
    for cls in reversed(getattr(values, value).__mro__):
        for name, said in getattr(cls, "__annotations__", {}).items():
            if not name.startswith("_"):
                found[name] = type_or_none(str(said)) or ANY
        for name, member in vars(cls).items():
            if isinstance(member, property) and not name.startswith("_"):
                returned = getattr(member.fget, "__annotations__", {}).get("return", "Any")
                found[name] = type_or_none(str(returned)) or ANY
    return found


_COMPUTING = ("flow/compute", "flow/wait_until")
"""Leaves that have an expression among their parameters."""
_CONDITIONS = ("precondition", "if", "while")
"""Keys whose expression is true or false."""


def check_expressions(analysis: TaskAnalysis) -> None:
    """Find expressions that can't be read, unknown variables in them, and parts of wrong types."""
    for placed in analysis.nodes:
        if isinstance(placed.node, Leaf) and placed.node.node in _COMPUTING:
            _over_inputs(analysis, placed, placed.node)
        for key, text in expressions_of(placed.node):
            try:
                expression = parse_expression(text)
            except ExpressionError as error:
                analysis.add(placed.path, key, "bad-expression", str(error))
                continue
            _names(analysis, placed, key, expression)
            _types(analysis, placed, key, expression)


def _over_inputs(analysis: TaskAnalysis, placed: PlacedNode, leaf: Leaf) -> None:
    """Find what is wrong with the expression of a leaf, which reads its inputs."""
    at, text = ("with", "expression"), leaf.with_.get("expression")
    try:
        names = parse_expression(text).names if isinstance(text, str) else ()
    except ExpressionError as error:
        analysis.add(placed.path, at, "bad-expression", str(error))
        return
    for name in sorted({*names} - {*leaf.in_}):
        message = f"`{text}` reads {name!r}, and no variable is bound to it (bound: {listing(leaf.in_)})"
        analysis.add(
            placed.path,
            at,
            "undeclared-variable",
            message,
            "bind a variable to one of the inputs `a` to `h`, and read that",
        )


def _names(analysis: TaskAnalysis, placed: PlacedNode, key: str, expression: Expression) -> None:
    scope = placed.scope_of(key)
    for name in expression.names:
        if name not in scope:
            message = f"`{expression.text}` reads {name!r}, which isn't declared"
            new = "declare it in `data` of an enclosing container; text is written in quotes"
            analysis.unknown(placed.path, key, "undeclared-variable", message, name, scope, new)


def _types(analysis: TaskAnalysis, placed: PlacedNode, key: str, expression: Expression) -> None:
    wrong: list[str] = []

    def note(part: ast.expr, reason: str) -> None:
        wrong.append(reason)
        message = f"`{expression.text}`, column {expression.column(part)}: {reason}"
        analysis.add(placed.path, key, "wrong-expression-type", message)

    scope = placed.scope_of(key)
    types: dict[str, Type] = {name: scope[name].type or ANY for name in expression.names if name in scope}
    given = type_of(expression, types, note)
    if key in _CONDITIONS and given.name not in ("bool", "Any") and not wrong:
        message = f"`{expression.text}` gives a {given}; `{key}` has to be true or false"
        analysis.add(placed.path, key, "wrong-expression-type", message, "compare it with something")
