"""The process that expands a xacro file: it computes, and does nothing else.

It reads `{"file", "arguments", "packages"}` as JSON from stdin and writes `{"text", "files", "left"}` or `{"error"}`;
`left` says what was left out, since its package isn't here. The `xacro` package looks for `__` in the outermost part of
an expression alone, and gives `$(eval ...)` all of Python. Here every name of an expression is looked at, `$(eval ...)`
gets what `${...}` has, and an audit hook (PEP 578) refuses what starts, sends, writes or removes things.
"""

from __future__ import annotations

import ast
import contextlib
import json
import os
import resource
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from types import AsyncGeneratorType, CodeType, CoroutineType, FrameType, GeneratorType, TracebackType
from typing import Any

from grip_bt.base.errors import GripError, MissingPartError

from .packages import Packages

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


def _guard(xacro: Any) -> None:
    """Have the `xacro` package refuse expressions that do something; for good, in this process."""
    inner, arguments = xacro.safe_eval, xacro.substitution_args
    evaluate = arguments._eval

    def guarded(expression: str, globals: dict[str, object], locals: object = None) -> object:
        look_at(expression)
        return inner(expression, globals, locals)

    def of_arguments(text: str, context: object) -> str:
        look_at(text)
        return str(evaluate(text, context))

    def with_few(text: str, globals: object, locals: Mapping[str, object]) -> object:
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
        hidden = name.startswith("_" if isinstance(node, ast.Attribute) else "__")  # files call properties `_so_`
        if hidden or (isinstance(node, ast.Attribute) and name in _INSIDES):
            raise UnsafeExpressionError(f"`{name}` isn't for expressions of a robot's description: they only compute")


def forbid_acts() -> Callable[[str, tuple[object, ...]], None]:
    """Refuse, from here on in this process, what starts, sends, writes or removes anything; return the audit hook."""

    def hook(event: str, args: tuple[object, ...]) -> None:
        writes = event == "open" and isinstance(args[1], str) and not _WRITES.isdisjoint(args[1])
        if writes or event.startswith(_ACTS):
            raise UnsafeExpressionError(f"a robot's description may not do this: {event}")

    sys.addaudithook(hook)
    return hook


MEMORY = 1024**3
SECONDS = 20
DEEPEST = 600
"""Of Python's recursion: beyond it, macros that call one another end in an error instead of a crash."""


def main() -> None:
    """Answer the one request."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
    request = json.loads(sys.stdin.read())
    with contextlib.redirect_stdout(sys.stderr):
        reply = _expanded(request["file"], request["arguments"], request["packages"])
    sys.stdout.write(json.dumps(reply))


NOWHERE = "/package-that-is-not-here"
"""Where packages that can't be found are looked for."""


def _leave_out(xacro: Any, known: Packages) -> list[str]:
    """Have `xacro` leave out what files include of packages that aren't here, and their macros; return it, it grows."""
    include, call, left = xacro.process_include, xacro.handle_macro_call, list[str]()

    def find(name: str) -> str:
        try:
            return str(known.find(name))
        except MissingPartError as error:
            left.append(str(error))
            return f"{NOWHERE}/{name}"

    def included(element: Any, macros: object, symbols: object, follow: object) -> None:
        try:
            include(element, macros, symbols, follow)
        except xacro.XacroException as error:
            if not str(getattr(error.exc, "filename", "")).startswith(NOWHERE):
                raise
            xacro.replace_node(element, by=None)

    def called(node: Any, macros: object, symbols: object) -> bool:
        try:
            return bool(call(node, macros, symbols))
        except xacro.XacroException as error:
            if not left or f"unknown macro name: {node.tagName}" not in str(error):
                raise
            left.append(f"the macro {node.tagName} isn't known without it")
            xacro.replace_node(node, by=None)
            return True

    xacro.substitution_args._eval_find = find
    xacro.process_include, xacro.handle_macro_call = included, called
    return left


def _expanded(file: str, arguments: dict[str, str], packages: dict[str, str]) -> dict[str, str | list[str]]:
    import xacro
    import xacro.substitution_args

    _guard(xacro)
    left = _leave_out(xacro, Packages({name: Path(folder) for name, folder in packages.items()}, (Path(file),)))
    sys.setrecursionlimit(DEEPEST)
    sys.dont_write_bytecode = True
    forbid_acts()
    try:
        text = xacro.process_file(file, mappings=arguments).toxml()
        files = sorted({file, *(f for f in map(os.path.abspath, xacro.all_includes) if not f.startswith(NOWHERE))})
        return {"text": text, "files": files, "left": list(dict.fromkeys(left))}
    except (GripError, UnsafeExpressionError) as error:
        return {"error": str(error)}
    except RecursionError:
        return {"error": "macros, properties or includes call themselves without end"}
    except MemoryError:
        return {"error": f"it takes more than {MEMORY // 2**20} MiB to expand"}
    except Exception as error:  # noqa: BLE001 - the file's own expressions raise whatever they like
        return {"error": " ".join(f"{type(error).__name__}: {error}".split())}


if __name__ == "__main__":
    main()
