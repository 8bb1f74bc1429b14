"""What an export asks of somebody's classes, read in their source: a conversion imports nothing."""

from __future__ import annotations

import ast
from pathlib import Path

from grip_bt.task.catalog import AllowedImports, Manifest
from grip_bt.task.catalog.source_code import line_of, source_of


def is_plain(manifest: Manifest) -> bool:
    """Tell whether a node is a behaviour of py_trees that knows nothing of grip; one that can't be read is grip's."""
    where, _, name = manifest.implementation.rpartition(":")
    if where.partition(".")[0] == "grip_bt":
        return False
    if where.partition(".")[0] == "py_trees":
        return True
    file = _file_of(where)
    names = [] if file is None else [each for each in line_of(file, name) if isinstance(each, str)]
    return bool(names) and names[0].startswith("py_trees.")


def takes_name(behaviour: str, code: AllowedImports) -> bool:
    """Tell whether a class or function has a parameter `name`; what can't be read has one, as behaviours do."""
    module, _, name = behaviour.partition(":")
    try:
        file = source_of(module, code.folder)
    except ModuleNotFoundError:
        return True
    for each in () if file is None else line_of(file, name):
        makers = [] if isinstance(each, str) else [each.syntax]
        if makers and isinstance(makers[0], ast.ClassDef):
            makers = [m for m in makers[0].body if isinstance(m, ast.FunctionDef) and m.name == "__init__"]
        for maker in makers:
            assert isinstance(maker, ast.FunctionDef | ast.AsyncFunctionDef), "a class was looked into"
            given = maker.args
            return "name" in {a.arg for a in (*given.posonlyargs, *given.args, *given.kwonlyargs)}
    return True


def _file_of(where: str) -> Path | None:
    if where.endswith(".py"):
        return Path(where)
    try:
        return source_of(where)
    except ModuleNotFoundError:
        return None
