"""Expressions of xacro files compute, and do nothing else: what the `xacro` package lets through is refused here.

The package looks for `__` in the outermost part of an expression alone, so that a lambda hides anything, and gives
`$(eval ...)` all of Python. Here every name of an expression is looked at, `$(eval ...)` gets what `${...}` has, and in
a process that only expands a file an audit hook (PEP 578) refuses what starts, sends, writes or removes something.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable, Mapping
from types import AsyncGeneratorType, CodeType, CoroutineType, FrameType, GeneratorType, TracebackType
from typing import Any

_BUILTINS: dict[str, object] = {
    b.__name__: b
    for b in (
        *(abs, all, any, bool, dict, divmod, enumerate, float, int, len, list, map, max, min, range, round, set),
        *(sorted, str, sum, tuple, zip),
    )
}
_INSIDES = frozenset(
    name
    for type_ in (AsyncGeneratorType, CodeType, CoroutineType, FrameType, GeneratorType, TracebackType)
    for name in dir(type_)
    if name.partition("_")[0] in ("ag", "co", "cr", "f", "gi", "tb")
)
"""Attributes by which a generator leads to the modules of the interpreter."""
_ACTS = (
    *("subprocess.", "os.system", "os.exec", "os.posix_spawn", "os.spawn", "os.fork", "os.startfile", "os.putenv"),
    *("os.remove", "os.rename", "os.rmdir", "os.mkdir", "os.link", "os.symlink", "os.chmod", "os.chown", "os.truncate"),
    *("os.kill", "shutil.", "socket.", "ctypes.", "webbrowser.", "tempfile.", "pty.", "sqlite3.", "urllib."),
)
_WRITES = frozenset("wax+")


class UnsafeExpressionError(Exception):
    """An expression of a file that wants more than values."""


def guard(xacro: Any) -> None:
    """Have the `xacro` package refuse expressions that do something; for good, in this process.

    Args:
        xacro: the module.
    """
    inner, arguments = xacro.safe_eval, xacro.substitution_args
    evaluate = arguments._eval

    def guarded(expression: str, globals: Any, locals: Any = None) -> Any:
        look_at(expression)
        return inner(expression, globals, locals)

    def of_arguments(text: str, context: Any) -> str:
        look_at(text)
        return str(evaluate(text, context))

    def with_few(text: str, globals: Any, locals: Mapping[str, Any]) -> Any:
        return eval(text, {"__builtins__": _BUILTINS}, locals)

    xacro.safe_eval, arguments._eval, arguments.eval = guarded, of_arguments, with_few
    for name in ("vars", "type"):  # by these a text in quotes becomes an attribute
        xacro._global_symbols["python"].pop(name, None)


def look_at(expression: str) -> None:
    """Refuse an expression that goes behind values.

    Raises:
        UnsafeExpressionError: it names something that begins with `_`, or the insides of Python's own objects.
    """
    try:
        tree = ast.parse(expression.strip(), mode="eval")
    except SyntaxError:
        return  # said by xacro, in its words
    for node in ast.walk(tree):
        name = node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ""
        if name.startswith("_") or (isinstance(node, ast.Attribute) and name in _INSIDES):
            raise UnsafeExpressionError(f"`{name}` isn't for expressions of a robot's description: they only compute")


def forbid_acts() -> Callable[[str, tuple[Any, ...]], None]:
    """Refuse, from here on in this process, what starts, sends, writes or removes anything; return the audit hook."""

    def hook(event: str, args: tuple[Any, ...]) -> None:
        writes = event == "open" and isinstance(args[1], str) and not _WRITES.isdisjoint(args[1])
        if writes or event.startswith(_ACTS):
            raise UnsafeExpressionError(f"a robot's description may not do this: {event}")

    sys.addaudithook(hook)
    return hook
