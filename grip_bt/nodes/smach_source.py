"""Legacy Python files: read as they are, converted in memory from Python 2, imported under own names."""

from __future__ import annotations

import ast
import logging
import sys
import tokenize
import warnings
from dataclasses import dataclass
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from types import ModuleType
from typing import Any

from grip_bt import smach_compat
from grip_bt.base.errors import DocumentError

_TAB = 8
"""Columns of a tab, which Python 2 allowed to be mixed with spaces."""

# Old spellings only: nothing here changes what Python 3 code means. Fixers that wrap calls in list(...) are needed,
# since Python 2 code indexes what dict.keys(), map and filter return.
_FIXERS = (
    *("apply", "basestring", "dict", "except", "exec", "execfile", "filter", "funcattrs", "has_key", "idioms"),
    *("imports", "intern", "itertools", "itertools_imports", "long", "map", "methodattrs", "ne", "next", "nonzero"),
    *("numliterals", "paren", "print", "raise", "raw_input", "reduce", "repr", "standarderror", "throw"),
    *("tuple_params", "unicode", "urllib", "xrange", "zip"),
)


@dataclass(frozen=True)
class Source:
    """A file that can be parsed: its text in Python 3 and its syntax, with the file's own line numbers.

    `converted` says whether it is Python 2 and was converted, which keeps lines.
    """

    path: Path
    text: str
    tree: ast.Module
    converted: bool


def read_source(path: Path) -> Source:
    """Read a Python file of any age.

    Raises:
        DocumentError: it can't be read, or is neither Python 3 nor Python 2.
    """
    try:
        with tokenize.open(path) as file:
            text = file.read()
    except (OSError, SyntaxError, UnicodeDecodeError) as error:
        raise DocumentError(f"can't be read: {error}", str(path)) from error
    try:
        return Source(path, text, _parse(text), False)
    except (SyntaxError, ValueError) as first:
        try:
            whole = text.expandtabs(_TAB)
            converted = str(_converter().refactor_string(whole if whole.endswith("\n") else whole + "\n", str(path)))
            return Source(path, converted, _parse(converted), True)
        except Exception:  # noqa: BLE001 - the converter raises whatever it likes; the first error says what is wrong
            line = getattr(first, "lineno", None)
            raise DocumentError(f"is neither Python 3 nor Python 2: {first}", str(path), line) from first


def _parse(text: str) -> ast.Module:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # invalid escapes in old regular expressions
        return ast.parse(text)


@lru_cache(maxsize=1)
def _converter() -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # lib2to3 leaves Python with 3.13
        from lib2to3.refactor import RefactoringTool

    logging.getLogger("RefactoringTool").setLevel(logging.ERROR)
    logging.getLogger("lib2to3.main").setLevel(logging.ERROR)
    return RefactoringTool([f"lib2to3.fixes.fix_{name}" for name in _FIXERS])


def load_legacy(path: Path, ros: bool = True) -> ModuleType:
    """Import a legacy file, once per process, with `smach_compat` as its `smach` and `smach_ros`.

    Its folder joins the end of `sys.path`, so that it finds its neighbours.

    Args:
        path: the file.
        ros: whether it gets a `smach_ros` that works; else it gets what the process has.

    Raises:
        DocumentError: see `read_source`.
        GripError: another `smach` is loaded already.
        Exception: whatever the file raises when it is imported.
    """
    path = path.resolve()
    name = f"grip_legacy_{sha256(str(path).encode()).hexdigest()[:12]}"
    if name in sys.modules:
        return sys.modules[name]
    source = read_source(path)
    smach_compat.install(ros=ros)
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))
    module = ModuleType(name)
    module.__file__ = str(path)
    sys.modules[name] = module
    try:
        exec(compile(source.tree, str(path), "exec"), module.__dict__)
    except BaseException:
        del sys.modules[name]
        raise
    return module
