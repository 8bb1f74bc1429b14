"""Expressions of a task as Python over the variables of the file. Their language is a part of Python's."""

from __future__ import annotations

import ast
import copy
from collections.abc import Mapping

from grip_bt.base.expression import CONSTANTS, parse_expression
from grip_bt.compilers.resolve import Part

from .layout import WIDTH, Code
from .plan import Plan


def function_of(text: str, part: Part, plan: Plan, *, around: bool = False) -> Code:
    """Return a function that computes a condition: a lambda, or the name of one that is too long for a line.

    Args:
        text: the expression; every variable of it is declared.
        part: the node that has it.
        plan: takes the function, where it has a name.
        around: whether it sees the variables around the node, and not the node's own.
    """
    inner = _python(text, plan.visible(part, around=around))
    # What an attribute of a value compares to may be numpy's kind of bool, which py_trees refuses.
    own = any(isinstance(node, ast.Attribute) for node in ast.walk(parse_expression(text).tree))
    return _function(f"bool({inner})" if own else inner, "bool", f"condition_of_{part.name}", plan)


def value_of(text: str, part: Part, plan: Plan) -> Code:
    """Return a function that computes any value, likewise."""
    return _function(_python(text, plan.visible(part)), "Any", f"value_of_{part.name}", plan)


def _function(body: str, returns: str, name: str, plan: Plan) -> Code:
    if len(body) < WIDTH // 2 - 8:
        return Code(f"lambda: {body}")
    name = plan.identifiers.take(name)
    skip = "  # fmt: skip" if len(body) + len("        return ") > WIDTH else ""
    plan.statements.append(f"\n    def {name}() -> {returns}:\n        return {body}{skip}\n")
    return Code(name)


def _python(text: str, variables: Mapping[str, str]) -> str:
    tree = copy.deepcopy(parse_expression(text).tree)
    return ast.unparse(ast.fix_missing_locations(_Reading(variables).visit(tree)))


class _Reading(ast.NodeTransformer):
    def __init__(self, variables: Mapping[str, str]):
        self.variables = variables

    def visit_Call(self, node: ast.Call) -> ast.Call:
        """Go on with the arguments; the function isn't a variable."""
        node.args = [self.visit(argument) for argument in node.args]
        return node

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.expr:
        """Write `not a in b` as `a not in b`, as people do."""
        match node:
            case ast.UnaryOp(ast.Not(), ast.Compare(ops=[ast.In() | ast.Is() as way]) as inner):
                inner.ops = [ast.NotIn() if isinstance(way, ast.In) else ast.IsNot()]
                return self.visit_Compare(inner)
        node.operand = self.visit(node.operand)
        return node

    def visit_Compare(self, node: ast.Compare) -> ast.Compare:
        """Go on with the operands."""
        node.left = self.visit(node.left)
        node.comparators = [self.visit(other) for other in node.comparators]
        return node

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """Read a variable."""
        if node.id in CONSTANTS:
            return ast.Constant(CONSTANTS[node.id])
        return ast.Call(ast.Attribute(ast.Name(self.variables[node.id]), "get"), [], [])
