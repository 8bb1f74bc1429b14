"""Expressions of a task as scripts of BT.CPP that mean the same."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping

from grip_bt.base.expression import CONSTANTS, parse_expression
from grip_bt.nodes.btcpp.script import SIGNS


def script_of(
    text: str, type_of: Callable[[str], str], names: Mapping[str, str] | None = None, wide: bool = False
) -> str:
    """Return an expression of a task as a script that comes to the same.

    Args:
        names: how it calls variables -> these.
        wide: whether it may look another way, and doesn't come back as it was.

    Raises:
        ValueError: BT.CPP has no words for a part of it, or means something else by them.
    """
    return (_WideWriter if wide else _Writer)(type_of, names or {}).text(parse_expression(text).tree)


class _Writer:
    def __init__(self, type_of: Callable[[str], str], names: Mapping[str, str]):
        self.type_of, self.names = type_of, names

    def text(self, node: ast.expr) -> str:
        match node:
            case ast.Constant(value=bool() as value):
                return str(value).lower()
            case ast.Constant(value=int() | float() as value):
                return repr(value)
            case ast.Constant(value=str() as value) if value.isascii() and value.isprintable():
                if "'" not in value:  # there is no other quote, and no escape
                    return f"'{value}'"
            case ast.Name(id=name) if isinstance(CONSTANTS.get(name), bool):
                return name
            case ast.Name(id=name) if name not in CONSTANTS:
                return self.names.get(name, name)
            case ast.UnaryOp(op=ast.Not(), operand=operand):
                return f"!{self.inside(operand)}"
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return f"-{self.inside(operand)}"
            case ast.BoolOp(op=op, values=values):
                return (" && " if isinstance(op, ast.And) else " || ").join(self.operand(v) for v in values)
            case ast.BinOp(left=left, op=op, right=right) if type(op) in SIGNS:
                return f"{self.inside(left)} {SIGNS[type(op)]} {self.inside(right)}"
            case ast.Compare(left=left, ops=ops, comparators=others) if all(type(op) in SIGNS for op in ops):
                return self.comparison([left, *others], [SIGNS[type(op)] for op in ops])
        raise ValueError(f"`{ast.unparse(node)}` has no equivalent")

    def comparison(self, operands: list[ast.expr], signs: list[str]) -> str:
        for sign in signs:
            if sign in ("==", "!=") and not all(self.exact(operand) for operand in operands):
                raise ValueError("BT.CPP takes numbers within 1.2e-7 for equal; compare whole numbers, texts or truth")
        text = self.inside(operands[0])
        for sign, operand in zip(signs, operands[1:], strict=True):
            text += f" {sign} {self.inside(operand)}"
        return text

    def exact(self, node: ast.expr) -> bool:
        """Tell whether equality with this operand is the same in both languages."""
        if isinstance(node, ast.Constant):
            return isinstance(node.value, bool | int | str)
        if isinstance(node, ast.Name):
            return node.id in CONSTANTS or self.type_of(self.names.get(node.id, node.id)) in ("int", "bool", "str")
        return False

    def operand(self, node: ast.expr) -> str:
        """Return an operand of `&&` and `||`, which bind equally there."""
        return f"({self.text(node)})" if isinstance(node, ast.BoolOp) else self.text(node)

    def inside(self, node: ast.expr) -> str:
        """Return an operand of anything else."""
        text = self.text(node)
        simple = isinstance(node, ast.Name) or (isinstance(node, ast.Constant) and not text.startswith("-"))
        return text if simple else f"({text})"


class _WideWriter(_Writer):
    """What BT.CPP has no word for, in those that it has; whole numbers only."""

    def text(self, node: ast.expr) -> str:
        match node:
            case ast.BinOp(left=left, op=ast.Mod() | ast.FloorDiv() as op, right=ast.Constant(value=int(by))) if by > 0:
                whole = self.inside(left)
                down = f"~(~(({whole}) / {by}))"  # a complement cuts off what is behind the point, towards 0
                rest = f"({whole} - {by} * ({down}))"
                if isinstance(op, ast.Mod):
                    return f"({rest} < 0 ? {rest} + {by} : {rest})"
                return f"({rest} < 0 ? ({down}) - 1 : ({down}))"
            case ast.Call(func=ast.Name(id="abs"), args=[value]):
                said = self.inside(value)
                return f"({said} < 0 ? (0 - {said}) : {said})"
            case ast.Call(func=ast.Name(id="max" | "min" as name), args=[one, *others]) if others:
                made, sign = self.inside(one), ">=" if name == "max" else "<="
                for other in others:
                    made = f"({made} {sign} {self.inside(other)} ? {made} : {self.inside(other)})"
                return made
            case ast.Compare(left=left, ops=[ast.In() | ast.NotIn() as sense], comparators=[ast.List(elts=items)]):
                any_one = " || ".join(f"({self.comparison([left, item], ['=='])})" for item in items) or "false"
                return f"({any_one})" if isinstance(sense, ast.In) else f"!({any_one})"
        return super().text(node)

    def exact(self, node: ast.expr) -> bool:
        match node:
            case ast.BinOp(left=left, op=ast.Add() | ast.Sub() | ast.Mult() | ast.Mod() | ast.FloorDiv(), right=right):
                return self.exact(left) and self.exact(right)
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return self.exact(operand)
            case ast.Call(args=args):
                return all(map(self.exact, args))
        return super().exact(node)
