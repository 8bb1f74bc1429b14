"""py_trees with its three known fixes: no debug messages, a quick test of statuses, no generator without use.

A copy of the installed package is patched, in a folder of its own; a process that has it first in its path ticks
the same trees: `plan_patched.py FOLDER` reads lines `family nodes` and answers with the seconds of a tick.
"""

from __future__ import annotations

import ast
import shutil
import sys
from pathlib import Path


class Fixes(ast.NodeTransformer):
    """The three fixes, in the syntax tree of a module."""

    def visit_Expr(self, node: ast.Expr) -> ast.AST:
        """Drop what would be logged for debugging."""
        return ast.Pass() if ast.unparse(node).startswith("self.logger.debug(") else node

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        """Look at the class of what should be a status."""
        if ast.unparse(node) == "new_status not in list(common.Status)":
            return ast.parse("new_status.__class__ is not common.Status", mode="eval").body
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        """Don't make a generator at the end of each `stop`."""
        self.generic_visit(node)
        if node.name == "stop":
            node.body = [line for line in node.body if ast.unparse(line) != "self.iterator = self.tick()"]
        return node


def patch(package: Path, folder: Path) -> None:
    """Write the patched copy of `package` into `folder`."""
    copy = folder / package.name
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("behaviour.py", "composites.py", "decorators.py"):
        tree = Fixes().visit(ast.parse((copy / name).read_text()))
        (copy / name).write_text(ast.unparse(ast.fix_missing_locations(tree)))


def serve() -> None:
    """Answer until the end of input."""
    from plan_families import FULL, STEADY, pick_task
    from plan_timing import seconds

    makers = {**FULL, **STEADY, "pick": lambda nodes: pick_task()}
    for line in sys.stdin:
        family, nodes = line.rstrip("\n").rsplit(" ", 1)
        print(seconds(makers[family](int(nodes)).tick_once), flush=True)


if __name__ == "__main__":
    sys.path.insert(0, sys.argv[1])
    serve()
