"""Modules as text: where they are, what they define, and which of them tasks may import. Nothing is imported."""

from __future__ import annotations

import ast
import sys
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import lru_cache
from importlib.machinery import PathFinder
from pathlib import Path
from typing import Annotated, Literal

from pydantic import StringConstraints

_OURS = ("grip_bt", "py_trees")
"""Packages whose classes are known by their names."""


def source_of(module: str, folder: Path | None = None) -> Path | None:
    """Return the Python file of a module, as an import would find it; None where it isn't one.

    Raises:
        ModuleNotFoundError: there is no such module here.
    """
    where = [*sys.path, *([str(folder)] if folder is not None else [])]
    found, words = None, module.split(".")
    for at, word in enumerate(words):
        found = PathFinder.find_spec(word, [str(entry) or "." for entry in where])
        if found is None:
            raise ModuleNotFoundError(f"there is no module {'.'.join(words[: at + 1])!r} here", name=module)
        inside = found.submodule_search_locations or ()
        where = list(getattr(inside, "_path", inside))  # a namespace's would ask for its imported parent
    origin = None if found is None else found.origin
    return Path(origin) if origin is not None and origin.endswith(".py") else None


def names_in(file: Path) -> frozenset[str] | None:
    """Return the names that a file defines at its top level; None where only running it could tell."""
    module = _syntax_of(file)
    names = frozenset() if module is None else frozenset(_names(module))
    return None if module is None or names & {"*", "__getattr__"} else names


@dataclass(frozen=True, slots=True)
class _Definition:
    """A class or function at the top level of a file.

    Attributes:
        bases: full names of what a class is made of; those of the file itself without a module.
    """

    file: Path
    syntax: ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
    bases: tuple[str, ...]


def _definition_of(file: Path, name: str) -> _Definition | None:
    module = _syntax_of(file)
    known = {} if module is None else dict(imported(module))
    for item in [] if module is None else module.body:
        if isinstance(item, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) and item.name == name:
            return _Definition(file, item, tuple(_full(base, known) for base in getattr(item, "bases", ())))
    return None


def line_of(file: Path, name: str, folder: Path | None = None) -> Iterator[_Definition | str]:
    """Yield a definition and what it is made of, nearest first; full names of what has no source to look into."""
    todo, seen = [(file, name)], set[tuple[Path, str]]()
    while todo:
        here = todo.pop(0)
        found = None if here in seen else _definition_of(*here)
        seen.add(here)
        if found is None:
            continue
        yield found
        for base in found.bases:
            module, _, inner = base.rpartition(".")
            there: Path | None = found.file
            if module.partition(".")[0] in _OURS:
                yield base
                continue
            try:
                there = source_of(module, folder) if module else found.file
            except ModuleNotFoundError:
                there = None
            if there is None:
                yield base
            else:
                todo.append((there, inner))


def imported(module: ast.Module) -> Iterator[tuple[str, str]]:
    """Yield the names that a module's top level imports, with what they stand for."""
    for item in module.body:
        if isinstance(item, ast.Import):
            for name in item.names:
                yield (name.asname or name.name.split(".")[0]), (name.name if name.asname else name.name.split(".")[0])
        elif isinstance(item, ast.ImportFrom) and not item.level:
            for name in item.names:
                yield name.asname or name.name, f"{item.module}.{name.name}"


def _syntax_of(file: Path) -> ast.Module | None:
    try:
        there = file.stat()
    except OSError:
        return None
    return _parsed(file, there.st_mtime_ns, there.st_size)


@lru_cache(maxsize=64)
def _parsed(file: Path, changed: int, size: int) -> ast.Module | None:
    try:
        return ast.parse(file.read_bytes())
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
        return None


def _full(name: ast.expr, known: dict[str, str]) -> str:
    if isinstance(name, ast.Attribute):
        return f"{_full(name.value, known)}.{name.attr}"
    return known.get(name.id, name.id) if isinstance(name, ast.Name) else ""


def _names(module: ast.Module) -> Iterator[str]:
    """Yield every name that is bound outside of functions and classes; `*` for those that nobody can know."""
    stack: list[ast.AST] = list(module.body)
    while stack:
        match stack.pop():
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
                yield name
            case ast.Import(names=names) | ast.ImportFrom(names=names):
                yield from ((each.asname or each.name).partition(".")[0] for each in names)
            case ast.Name(id=name, ctx=ast.Store()):
                yield name
            case other:
                stack.extend(ast.iter_child_nodes(other))


_NAME = r"[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z_][A-Za-z0-9_]*)*"
CodePath = Annotated[str, StringConstraints(pattern=f"^{_NAME}(:{_NAME})?$")]
"""`package.module`, or `package.module:Name`."""
_TRUSTED = "py_trees"
"""The package whose behaviours every task may use."""


@dataclass(frozen=True, slots=True)
class AllowedImports:
    """What the tasks of a project may import.

    Attributes:
        listed: what the project lists: `package.module` for the behaviours that it, or a module below it, holds;
            `package.module:Name` for one class, or for one function that makes a behaviour.
        folder: where modules are looked for last: the project's; None for where Python looks alone.
    """

    listed: tuple[str, ...] = ()
    folder: Path | None = None

    def allows(self, behaviour: str) -> bool:
        """Tell whether a task may import `package.module:Name`."""
        module = behaviour.partition(":")[0]
        return self.names(behaviour) or any(_covers(entry, module) for entry in (_TRUSTED, *self.listed))

    def names(self, behaviour: str) -> bool:
        """Tell whether it is listed word for word, as a function has to be."""
        return behaviour in self.listed

    def is_third_party(self, behaviour: str) -> bool:
        """Tell whether it is the project's own code, or somebody's, and not py_trees'."""
        return not _covers(_TRUSTED, behaviour.partition(":")[0])

    def names_in(self, module: str) -> Collection[str] | None:
        """Return what a module defines at its top level, read in its source; None where that can't tell.

        Raises:
            ModuleNotFoundError: there is no such module here.
        """
        file = source_of(module, self.folder)
        return None if file is None else names_in(file)

    def kind_of(self, behaviour: str) -> Literal["class", "function", "other"] | None:
        """Return what `package.module:Name` is, as its module's source tells; None where that can't tell.

        Raises:
            ModuleNotFoundError: there is no such module here.
        """
        module, _, name = behaviour.partition(":")
        file = source_of(module, self.folder)
        found = None if file is None or "." in name else _definition_of(file, name)
        if found is not None:
            return "class" if isinstance(found.syntax, ast.ClassDef) else "function"
        return "other" if "." in name and not self.is_third_party(behaviour) else None


def _covers(entry: str, module: str) -> bool:
    return ":" not in entry and (module == entry or module.startswith(f"{entry}."))
