r"""The `.ini` files of the first GRIP: those of Qt's QSettings, with values that may be pickled.

Keys are percent-encoded and nested by a backslash; values are text with escapes, lists, and `@Variant(...)`, that holds
bytes. See Qt's documentation of `QSettings::IniFormat`. No library reads it without Qt.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from pathlib import Path

from grip_bt.base.errors import DocumentError

from .pickles import RefusedPickleError, plain_value

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
    """Return the values of a file by key: text, lists of text, what was pickled, or `Refused`.

    Raises:
        DocumentError: it can't be read, or isn't such a file; with the line.
    """
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
    """Return the parts of a key."""

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
    """Return the Python object in a QVariant: type, name of the type, length, pickle; numbers are big-endian.

    Raises:
        ValueError: it holds something else.
    """
    (kind,) = struct.unpack_from(">I", data)
    if kind != _USER_TYPE:
        raise ValueError(f"a QVariant of Qt's type {kind}, not of a Python object")
    (length,) = struct.unpack_from(">I", data, 4)
    name = data[8 : 8 + length]
    if name != _PYTHON_OBJECT:
        raise ValueError(f"a QVariant that holds {name[:40]!r}, not a Python object")
    (size,) = struct.unpack_from(">I", data, 8 + length)
    pickle = data[12 + length : 12 + length + size]
    if len(pickle) != size:
        raise ValueError("its end is missing")
    return plain_value(pickle)
