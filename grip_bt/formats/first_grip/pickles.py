"""Pickled plain containers, without unpickling: the opcodes are read by `pickletools` and only data is made of them.

The first GRIP kept its tasks as pickles. Python's unpickler calls what a file names; here nothing is ever called, no
class is looked up, and every opcode that isn't about plain values is refused by its name. One class is known by name,
`collections.OrderedDict`, which becomes a dict.
"""

from __future__ import annotations

import pickletools
from collections.abc import Callable
from typing import Any

from grip_bt.base.errors import GripError

LARGEST = 16 * 2**20
"""Longest pickle [bytes]."""
DEEPEST = 100
"""Deepest nesting of what is read."""
MOST = 1_000_000
"""Most values in what is read, shared ones counted each time."""


class RefusedPickleError(GripError):
    """Pickled data holds more than plain containers, or isn't a pickle.

    Attributes:
        what: what is in it that isn't read.
    """

    def __init__(self, what: str):
        self.what = what
        super().__init__(f"the pickled data is refused: {what}; only dicts, lists, tuples, text, numbers are read")


class _Mark:
    """Where the items of a container begin."""


class _Ordered:
    """`collections.OrderedDict`, as a name."""


_MARK, _ORDERED = _Mark(), _Ordered()
_VALUES = frozenset(
    (
        *("INT", "BININT", "BININT1", "BININT2", "LONG", "LONG1", "LONG4", "FLOAT", "BINFLOAT"),
        *("UNICODE", "SHORT_BINUNICODE", "BINUNICODE", "BINUNICODE8"),
        *("BINBYTES", "SHORT_BINBYTES", "BINBYTES8"),
    )
)
_TEXTS = frozenset(("STRING", "BINSTRING", "SHORT_BINSTRING"))
_CONSTANTS: dict[str, Any] = {"NONE": None, "NEWTRUE": True, "NEWFALSE": False}
_EMPTY: dict[str, Callable[[], Any]] = {"EMPTY_LIST": list, "EMPTY_DICT": dict, "EMPTY_TUPLE": tuple, "EMPTY_SET": list}
_TUPLES = {"TUPLE1": 1, "TUPLE2": 2, "TUPLE3": 3}


def plain_value(data: bytes) -> Any:
    """Return what is pickled: dicts, lists, tuples, sets as lists, text, bytes, numbers, booleans and None.

    Raises:
        RefusedPickleError: it is no pickle, or there is anything else in it; nothing was run.
    """
    if len(data) > LARGEST:
        raise RefusedPickleError(f"it has {len(data)} bytes, more than {LARGEST}")
    reader = _Reader()
    try:
        for opcode, argument, _ in pickletools.genops(data):
            if opcode.name == "STOP":
                return _counted(reader.result())
            reader.take(opcode.name, argument)
    except RefusedPickleError:
        raise
    except RecursionError:
        raise RefusedPickleError("it is nested too deeply") from None
    except Exception as error:  # noqa: BLE001 - pickletools raises many kinds for what isn't a pickle
        raise RefusedPickleError(f"it is no pickle ({type(error).__name__}: {str(error)[:80]})") from None
    raise RefusedPickleError("it has no end")


class _Reader:
    def __init__(self) -> None:
        self.stack: list[Any] = []
        self.memo: dict[int, Any] = {}
        self.names: list[str] = []

    def result(self) -> Any:
        if len(self.stack) != 1:
            raise RefusedPickleError("it is broken")
        return self.stack[0]

    def take(self, name: str, argument: Any) -> None:
        """Do what one opcode says, where that only makes data."""
        if name in _VALUES:
            self.stack.append(argument)
        elif name in _TEXTS:
            self.stack.append(_text(argument))
        elif name in _CONSTANTS:
            self.stack.append(_CONSTANTS[name])
        elif name in _EMPTY:
            self.stack.append(_EMPTY[name]())
        elif name in _TUPLES:
            self.stack[-_TUPLES[name] :] = [tuple(self.stack[-_TUPLES[name] :])]
        else:
            self.build(name, argument)

    def build(self, name: str, argument: Any) -> None:
        stack = self.stack
        match name:
            case "PROTO" | "FRAME":
                pass
            case "MARK":
                stack.append(_MARK)
            case "POP":
                stack.pop()
            case "POP_MARK":
                self.marked()
            case "DUP":
                stack.append(stack[-1])
            case "LIST" | "TUPLE" | "FROZENSET":
                items = self.marked()
                stack.append(tuple(items) if name == "TUPLE" else items)
            case "DICT":
                stack.append(_pairs(self.marked()))
            case "APPEND":
                _held(stack[-2], list).append(stack.pop())
            case "APPENDS" | "ADDITEMS":
                items = self.marked()
                _held(stack[-1], list).extend(items)
            case "SETITEM":
                value, key = stack.pop(), stack.pop()
                _held(stack[-1], dict)[key] = value
            case "SETITEMS":
                items = self.marked()
                _held(stack[-1], dict).update(_pairs(items))
            case "PUT" | "BINPUT" | "LONG_BINPUT":
                self.memo[argument] = stack[-1]
            case "MEMOIZE":
                self.memo[len(self.memo)] = stack[-1]
            case "GET" | "BINGET" | "LONG_BINGET":
                stack.append(self.memo[argument])
            case _:
                self.name_or_refuse(name, argument)

    def name_or_refuse(self, name: str, argument: Any) -> None:
        """Make an ordered dict; everything else that names or calls something is refused."""
        if name == "GLOBAL":
            self.stack.append(_ordered(*str(argument).split(" ", 1)))
        elif name == "STACK_GLOBAL":
            attribute, module = self.stack.pop(), self.stack.pop()
            self.stack.append(_ordered(str(module), str(attribute)))
        elif name == "REDUCE" and self.stack[-2] is _ORDERED:
            arguments = self.stack.pop()
            self.stack[-1] = _of_items(arguments)
        elif name in ("INST", "OBJ", "NEWOBJ", "NEWOBJ_EX"):
            raise RefusedPickleError(f"it makes an object ({name} {argument or ''})".replace(" )", ")"))
        else:
            raise RefusedPickleError(f"it uses the opcode {name}")

    def marked(self) -> list[Any]:
        """Take everything down to the last mark."""
        at = max(number for number, item in enumerate(self.stack) if item is _MARK)
        items = self.stack[at + 1 :]
        del self.stack[at:]
        return items


def _ordered(module: str, name: str) -> _Ordered:
    if (module, name) != ("collections", "OrderedDict"):
        raise RefusedPickleError(f"it names {module}.{name}")
    return _ORDERED


def _of_items(arguments: Any) -> dict[Any, Any]:
    if arguments == ():
        return {}
    (pairs,) = arguments
    return {key: value for key, value in pairs}


def _pairs(items: list[Any]) -> dict[Any, Any]:
    return dict(zip(items[::2], items[1::2], strict=True))


def _held(found: Any, kind: type) -> Any:
    if type(found) is not kind:
        raise RefusedPickleError(f"it adds to a {type(found).__name__}")
    return found


def _text(value: str) -> str:
    """Return text of Python 2, which has bytes: UTF-8 where it is."""
    try:
        return value.encode("latin-1").decode("utf-8")
    except UnicodeError:
        return value


def _counted(value: Any) -> Any:
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
        elif isinstance(found, _Mark | _Ordered):
            raise RefusedPickleError("it is broken")
    return value
