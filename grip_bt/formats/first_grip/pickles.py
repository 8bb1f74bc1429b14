"""Pickled plain containers, without running anything that they name.

The first GRIP kept its tasks as pickles. Python's unpickler calls what a file names. Here its Python form has opcodes
for plain values alone, and every other is refused by its name; no class is looked up. One is known by name,
`collections.OrderedDict`, which becomes a dict, and that is all that is ever called.
"""

from __future__ import annotations

import io
import pickle
import pickletools
from typing import Any, NoReturn

from grip_bt.base.errors import GripError

LARGEST = 16 * 2**20
"""Longest pickle [bytes]."""
DEEPEST = 100
"""Deepest nesting of what is read."""
MOST = 1_000_000
"""Most values in what is read, shared ones counted each time."""


class RefusedPickleError(GripError):
    """Pickled data holds more than plain containers, or isn't a pickle."""

    def __init__(self, what: str):
        self.what = what
        super().__init__(f"the pickled data is refused: {what}; only dicts, lists, tuples, text, numbers are read")


_KNOWN = pickle._Unpickler.dispatch
_OPCODES = {
    name: name
    for name in (
        *("PROTO", "FRAME", "STOP", "MARK", "POP", "POP_MARK", "DUP"),
        *("PUT", "BINPUT", "LONG_BINPUT", "MEMOIZE", "GET", "BINGET", "LONG_BINGET"),
        *("NONE", "NEWTRUE", "NEWFALSE", "FLOAT", "BINFLOAT"),
        *("INT", "BININT", "BININT1", "BININT2", "LONG", "LONG1", "LONG4"),
        *("UNICODE", "SHORT_BINUNICODE", "BINUNICODE", "BINUNICODE8"),
        *("BINBYTES", "SHORT_BINBYTES", "BINBYTES8", "STRING", "BINSTRING", "SHORT_BINSTRING"),
        *("EMPTY_LIST", "LIST", "APPEND", "APPENDS", "EMPTY_DICT", "DICT", "SETITEM", "SETITEMS"),
        *("EMPTY_TUPLE", "TUPLE", "TUPLE1", "TUPLE2", "TUPLE3", "GLOBAL", "STACK_GLOBAL"),
    )
} | {"EMPTY_SET": "EMPTY_LIST", "ADDITEMS": "APPENDS", "FROZENSET": "LIST"}
"""Opcode -> the one whose function makes it: sets become lists."""


def _code(name: str) -> int:
    return ord(getattr(pickle, name))


class _Opcodes(dict):  # type: ignore[type-arg]
    """The opcodes that only make data; any other is refused."""

    def __missing__(self, code: int) -> NoReturn:
        names = [opcode.name for opcode in pickletools.opcodes if opcode.code == chr(code)]
        raise RefusedPickleError(f"it uses the opcode {names[0]}" if names else f"it is no pickle (opcode {code})")


class _PlainUnpickler(pickle._Unpickler):
    stack: list[object]

    def load_reduce(self) -> None:
        """Make a dict of an ordered one."""
        arguments: Any = self.stack.pop()
        if self.stack[-1] is not dict:
            raise RefusedPickleError("it uses the opcode REDUCE")
        self.stack[-1] = dict(*arguments)

    def find_class(self, module: str, name: str) -> type[dict]:  # type: ignore[type-arg]
        """Refuse every name but one."""
        if (module, name) != ("collections", "OrderedDict"):
            raise RefusedPickleError(f"it names {module}.{name}")
        return dict

    def _decode_string(self, value: bytes) -> str:
        """Return text of Python 2, which has bytes: UTF-8 where it is."""
        try:
            return value.decode("utf-8")
        except UnicodeError:
            return value.decode("latin-1")

    dispatch = _Opcodes(
        {_code(name): _KNOWN[_code(made_as)] for name, made_as in _OPCODES.items()} | {_code("REDUCE"): load_reduce}
    )


def plain_value(data: bytes) -> object:
    """Return what is pickled: dicts, lists, tuples, sets as lists, text, bytes, numbers, booleans and None.

    Raises:
        RefusedPickleError: it is no pickle, or there is anything else in it; nothing was run.
    """
    if len(data) > LARGEST:
        raise RefusedPickleError(f"it has {len(data)} bytes, more than {LARGEST}")
    try:
        return _checked(_PlainUnpickler(io.BytesIO(data)).load())
    except RefusedPickleError:
        raise
    except Exception as error:  # noqa: BLE001 - pickle raises many kinds for what isn't a pickle
        raise RefusedPickleError(f"it is no pickle ({type(error).__name__}: {str(error)[:80]})") from None


def _checked(value: object) -> object:
    """Return the value; refuse one that holds itself, is too deep, or too big once its shared parts are written out."""
    left = MOST
    stack = [(value, 0)]
    while stack:
        found, depth = stack.pop()
        left -= 1
        if depth > DEEPEST or left < 0:
            raise RefusedPickleError(
                "it is nested too deeply" if depth > DEEPEST else f"it has more than {MOST} values"
            )
        if isinstance(found, dict):
            stack += [(each, depth + 1) for pair in found.items() for each in pair]
        elif isinstance(found, list | tuple):
            stack += [(each, depth + 1) for each in found]
        elif type(found) not in (str, bytes, int, float, bool, type(None)):
            raise RefusedPickleError("it is broken")
    return value
