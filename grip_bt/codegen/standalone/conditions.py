"""Expressions of a task as Python over the variables of the file. Their language is a part of Python's."""

from __future__ import annotations

import ast
import copy
from collections.abc import Mapping

from grip_bt.graph.expression import CONSTANTS, parse_expression

from .layout import Code


def condition(text: str, variables: Mapping[str, str]) -> Code:
    """Return a function without arguments that computes an expression.

    Args:
        text: the expression; every variable of it is declared.
        variables: variable of the task -> name in the file.
    """
    tree = copy.deepcopy(parse_expression(text).tree)
    inner = ast.unparse(ast.fix_missing_locations(_Reading(variables).visit(tree)))
    # What an attribute of a value compares to may be numpy's kind of bool, which py_trees refuses.
    own = any(isinstance(node, ast.Attribute) for node in ast.walk(parse_expression(text).tree))
    return Code(f"lambda: bool({inner})" if own else f"lambda: {inner}")


class _Reading(ast.NodeTransformer):
    def __init__(self, variables: Mapping[str, str]):
        self.variables = variables

    def visit_Call(self, node: ast.Call) -> ast.Call:
        node.args = [self.visit(argument) for argument in node.args]
        return node

    def visit_Name(self, node: ast.Name) -> ast.expr:
        if node.id in CONSTANTS:
            return ast.Constant(CONSTANTS[node.id])
        return ast.Call(ast.Attribute(ast.Name(self.variables[node.id]), "get"), [], [])
