"""BT.CPP's scripts as expressions of a task."""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass, field

from grip_bt.nodes.btcpp.script import EPSILON, SIGNS

LARGEST = 2**53


class Inexact(ValueError):
    """An expression has no exact equivalent: it is computed as the script that it is."""


@dataclass(frozen=True)
class Value:
    """An expression of a task; `Any` is a type that isn't known."""

    tree: ast.expr
    type: str

    @property
    def text(self) -> str:
        """How a task writes it."""
        return ast.unparse(self.tree)


@dataclass
class Translator:
    """Writes scripts as expressions, given what they call a blackboard key, and its type; notes what to know.

    Raises:
        Inexact: from every method, where there is none.
    """

    name_of: Callable[[str], str]
    type_of: Callable[[str], str]
    notes: list[str] = field(default_factory=list)

    def condition(self, script: ast.expr) -> Value:
        """Return the expression that is true where BT.CPP casts the script's value to true."""
        value = self.value(script)
        if value.type == "str":
            raise Inexact("a text as a condition")
        if value.type == "bool":
            return value
        return Value(ast.Compare(value.tree, [ast.NotEq()], [ast.Constant(0)]), "bool")

    def value(self, script: ast.expr) -> Value:
        """Return the expression that comes to the script's value."""
        match script:
            case ast.Constant():
                return literal(script)
            case ast.Name(id=name):
                kind = self.type_of(name)
                return Value(ast.Name(self.name_of(name)), kind if kind in ("bool", "int", "float", "str") else "Any")
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                found = self._number(operand)
                return Value(ast.UnaryOp(ast.USub(), found.tree), found.type)
            case ast.UnaryOp(op=ast.Not(), operand=ast.UnaryOp(op=ast.Not(), operand=operand)):
                return self.condition(operand)
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                return Value(_not(self.condition(operand)), "bool")
            case ast.BoolOp(op=op, values=values):
                return Value(ast.BoolOp(op, [self.condition(each).tree for each in values]), "bool")
            case ast.BinOp(op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div() | ast.MatMult()):
                return self._arithmetic(script)
            case ast.Compare():
                return self._comparison(script)
            case ast.IfExp(test=test, body=body, orelse=orelse):
                asked, then, other = self.condition(test), self.value(body), self.value(orelse)
                if (then.type, other.type) != ("bool", "bool"):
                    raise Inexact("`?:` inside of an expression")
                ways = [
                    ast.BoolOp(ast.And(), [one, two.tree]) for one, two in ((asked.tree, then), (_not(asked), other))
                ]
                return Value(ast.BoolOp(ast.Or(), list[ast.expr](ways)), "bool")
        raise Inexact("bits, or an assignment inside of an expression")

    def _arithmetic(self, script: ast.BinOp) -> Value:
        sign = SIGNS[type(script.op)]
        if sign == ".." or (sign == "+" and "str" in (self.value(script.left).type, self.value(script.right).type)):
            match script.left, script.right:
                case ast.Constant(value=str(one)), ast.Constant(value=str(other)):
                    return literal(ast.Constant(one + other))
            raise Inexact("joined texts")
        left, right = self._number(script.left), self._number(script.right)
        if sign == "/" and isinstance(right.tree, ast.Constant):
            if right.tree.value == 0:
                raise Inexact("infinity")
        elif sign == "/":
            what = f"a division by `{right.text}`"
            self.notes.append(f"{what}: where that is 0 the run ends as an error, not at infinity")
        types = {left.type, right.type}
        kind = "float" if sign == "/" or "float" in types else "int" if types == {"int"} else "Any"
        return Value(ast.BinOp(left.tree, script.op, right.tree), kind)

    def _number(self, script: ast.expr) -> Value:
        value = self.value(script)
        if value.type in ("bool", "str"):
            raise Inexact("no number")
        return value

    def _comparison(self, script: ast.Compare) -> Value:
        values = [self.value(operand) for operand in (script.left, *script.comparators)]
        pairs = [self._pair(a, op, b) for a, op, b in zip(values, script.ops, values[1:], strict=False)]
        if len(pairs) == 1:
            return Value(pairs[0], "bool")
        if any(isinstance(pair.left, ast.Call) for pair in pairs):
            return Value(ast.BoolOp(ast.And(), list[ast.expr](pairs)), "bool")
        return Value(ast.Compare(values[0].tree, script.ops, [value.tree for value in values[1:]]), "bool")

    def _pair(self, left: Value, op: ast.cmpop, right: Value) -> ast.Compare:
        types = {left.type, right.type}
        if "str" in types and not types <= {"str", "Any"}:
            raise Inexact("a text compared with a number")
        plain = ast.Compare(left.tree, [op], [right.tree])
        if not isinstance(op, ast.Eq | ast.NotEq) or types <= {"bool", "int", "str"}:
            return plain
        if "float" in types:
            if "bool" in types:
                raise Inexact("a truth value compared with a fraction")
            apart = ast.Call(ast.Name("abs"), [ast.BinOp(left.tree, ast.Sub(), right.tree)], [])
            near = ast.LtE() if isinstance(op, ast.Eq) else ast.Gt()
            return ast.Compare(apart, [near], [ast.Constant(EPSILON)])
        if "str" not in types:
            unknown = left.text if left.type == "Any" else right.text
            text = f"`{ast.unparse(plain)}`: nothing says of which type {unknown!r} is"
            self.notes.append(f"{text}; were it a fraction, BT.CPP would take numbers within 1.2e-7 for the same")
        return plain


def _not(value: Value) -> ast.expr:
    return ast.UnaryOp(ast.Not(), value.tree)


def literal(said: ast.Constant) -> Value:
    """Return a literal as an expression. Raises Inexact: expressions can't hold it."""
    match said.value:
        case bool(truth):
            return Value(ast.Name(str(truth).lower()), "bool")
        case str(text) if not any(c in text for c in "\\#\n\r\0") and not {"'", '"'} <= set(text):
            return Value(said, "str")
        case int() | float() as number if abs(number) <= LARGEST:
            return Value(said, type(number).__name__)
    raise Inexact("a text that an expression can't hold, or a number of which BT.CPP keeps the nearest double")
