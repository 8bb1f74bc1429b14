"""The `.ini` files of the first GRIP, which are Qt's QSettings; pickled values are read without running anything."""

from __future__ import annotations

import io
import pickle
import pickletools
import re
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from grip_bt.base.errors import DocumentError, GripError

LARGEST_PICKLE = 16 * 2**20
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


_OPCODES = (
    *("PROTO", "FRAME", "STOP", "MARK", "POP", "POP_MARK", "DUP", "GLOBAL", "STACK_GLOBAL", "REDUCE"),
    *("PUT", "BINPUT", "LONG_BINPUT", "MEMOIZE", "GET", "BINGET", "LONG_BINGET"),
    *("NONE", "NEWTRUE", "NEWFALSE", "FLOAT", "BINFLOAT", "INT", "BININT", "BININT1", "BININT2"),
    *("LONG", "LONG1", "LONG4", "UNICODE", "SHORT_BINUNICODE", "BINUNICODE", "BINUNICODE8"),
    *("BINBYTES", "SHORT_BINBYTES", "BINBYTES8", "STRING", "BINSTRING", "SHORT_BINSTRING"),
    *("EMPTY_LIST", "LIST", "APPEND", "APPENDS", "EMPTY_DICT", "DICT", "SETITEM", "SETITEMS"),
    *("EMPTY_TUPLE", "TUPLE", "TUPLE1", "TUPLE2", "TUPLE3"),
)
_CODES = [ord(getattr(pickle, name)) for name in _OPCODES]


class _Opcodes(dict):  # type: ignore[type-arg]
    def __missing__(self, code: int) -> NoReturn:
        names = [opcode.name for opcode in pickletools.opcodes if opcode.code == chr(code)]
        raise RefusedPickleError(f"it uses the opcode {names[0]}" if names else f"it is no pickle (opcode {code})")


class _PlainUnpickler(pickle._Unpickler):
    dispatch = _Opcodes({code: pickle._Unpickler.dispatch[code] for code in _CODES})

    def find_class(self, module: str, name: str) -> type[dict]:  # type: ignore[type-arg]
        """Refuse every name but one, which is a plain dict then; REDUCE calls nothing else."""
        if (module, name) != ("collections", "OrderedDict"):
            raise RefusedPickleError(f"it names {module}.{name}")
        return dict

    def _decode_string(self, value: bytes) -> str:
        """Return text of Python 2, which has bytes: UTF-8 where it is."""
        try:
            return value.decode("utf-8")
        except UnicodeError:
            return value.decode("latin-1")


def plain_value(data: bytes) -> object:
    """Return what is pickled: dicts, lists, tuples, text, bytes, numbers, booleans and None.

    Raises:
        RefusedPickleError: it is no pickle, or there is anything else in it; nothing was run.
    """
    if len(data) > LARGEST_PICKLE:
        raise RefusedPickleError(f"it has {len(data)} bytes, more than {LARGEST_PICKLE}")
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


LARGEST = 64 * 2**20
"""Longest file [bytes]."""
Key = tuple[str, ...]

_ESCAPES = dict(zip('abfnrtv"\\', '\a\b\f\n\r\t\v"\\', strict=True))
_PERCENT = re.compile(r"%U([0-9A-Fa-f]{4})|%([0-9A-Fa-f]{2})")
_USER_TYPE = 127
_PYTHON_OBJECT = b"PyQt_PyObject\0"


@dataclass(frozen=True)
class Refused:
    """A value that isn't read: why, and in which line."""

    reason: str
    line: int


def read_settings(path: Path) -> dict[Key, object]:
    """Return key -> text, texts, what was pickled, or `Refused`. Raises DocumentError with the line."""
    try:
        if path.stat().st_size > LARGEST:
            raise DocumentError(f"is larger than {LARGEST} bytes", str(path))
        text = path.read_bytes().decode("utf-8", errors="surrogateescape")
    except OSError as error:
        raise DocumentError(f"can't be read: {error.strerror or error}", str(path)) from error
    group: Key = ()
    found: dict[Key, object] = {}
    for number, line in enumerate(text.split("\n"), 1):
        line = line.strip()
        if not line or line.startswith(";"):
            continue
        if line.startswith("["):
            if not line.endswith("]"):
                raise DocumentError("a section without its `]`", str(path), number)
            group = () if line in ("[General]", "[%General]") else _key(line[1:-1])
            continue
        key, equal, value = line.partition("=")
        if not equal:
            raise DocumentError("neither a section nor `key=value`", str(path), number)
        values = [_variant(item, number) for item in _items(value.strip())]
        found[(*group, *_key(key.strip()))] = values[0] if len(values) == 1 else values
    return found


def _key(text: str) -> Key:
    def character(found: re.Match[str]) -> str:
        wide, narrow = found.groups()
        return chr(int(wide or narrow, 16))

    return tuple(_PERCENT.sub(character, part) for part in re.split(r"[\\/]", text) if part)


def _items(text: str) -> list[str]:
    """Return the items of a list, which commas part, without quotes and escapes."""
    items, item, quoted, at = [], "", False, 0
    while at < len(text):
        character = text[at]
        at += 1
        if character == '"':
            quoted = not quoted
        elif character == "," and not quoted:
            items.append(item.strip())
            item = ""
        elif character == "\\" and at < len(text):
            piece, at = _escape(text, at)
            item += piece
        else:
            item += character
    return [*items, item if quoted or not items else item.strip()]


def _escape(text: str, at: int) -> tuple[str, int]:
    """Return what the escape at `at`, behind its backslash, stands for, and where it ends."""
    if text[at] == "x":
        # Qt takes hexadecimal digits as long as there are some; it writes the character after them escaped then
        digits = re.match(r"[0-9A-Fa-f]{1,4}", text[at + 1 :])
        if digits is None:
            return "", at + 1
        return chr(int(digits.group(), 16)), at + 1 + digits.end()
    if text[at] in "01234567":
        digits = re.match(r"[0-7]{1,3}", text[at:])
        assert digits is not None, "there is one"
        return chr(int(digits.group(), 8) & 0xFFFF), at + digits.end()
    return _ESCAPES.get(text[at], ""), at + 1


def _variant(text: str, line: int) -> object:
    if text.startswith("@@"):
        return text[1:]
    kind, bracket, rest = text.partition("(")
    if not (kind.startswith("@") and bracket and rest.endswith(")")):
        return text
    inside = rest[:-1]
    if kind == "@Invalid":
        return None
    if kind in ("@ByteArray", "@String"):
        return inside
    if kind != "@Variant":
        return Refused(f"a value of the kind {kind}", line)
    try:
        return _pickled(inside.encode("latin-1"))
    except UnicodeEncodeError:
        return Refused("its bytes are damaged", line)
    except (RefusedPickleError, struct.error, ValueError) as error:
        return Refused(str(error), line)


def _pickled(data: bytes) -> object:
    """Return the Python object in a QVariant: type, name of the type, length, pickle; numbers are big-endian."""
    (kind,) = struct.unpack_from(">I", data)
    if kind != _USER_TYPE:
        raise ValueError(f"a QVariant of Qt's type {kind}, not of a Python object")
    (length,) = struct.unpack_from(">I", data, 4)
    name = data[8 : 8 + length]
    if name != _PYTHON_OBJECT:
        raise ValueError(f"a QVariant that holds {name[:40]!r}, not a Python object")
    (size,) = struct.unpack_from(">I", data, 8 + length)
    held = data[12 + length : 12 + length + size]
    if len(held) != size:
        raise ValueError("its end is missing")
    return plain_value(held)
