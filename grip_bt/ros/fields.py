"""Fields of a message, by the type strings that messages carry: `sequence<double, 3>`, `geometry_msgs/Point[4]`."""

from __future__ import annotations

import array
import re
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from grip_bt.base.errors import GripError, nearest

from .client.types import load_type, type_name

_CODES = {"float": "f", "double": "d", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H"}
_CODES |= {"int32": "i", "uint32": "I", "int64": "q", "uint64": "Q"}
WHOLE = frozenset(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64))
"""Types of whole numbers, as messages spell them."""
_ARRAY = re.compile(r"^(?:sequence<(?P<item>.+?)(?:, (?P<bound>\d+))?>|(?P<fixed>.+?)\[(?P<size>\d+)\])$")


class ConversionError(GripError):
    """A value doesn't fit a message, or a message doesn't fit a value.

    Attributes:
        path: the field, such as `returned_object[2].pose`; empty for the whole.
        reason: what is wrong.
    """

    def __init__(self, path: str, reason: str):
        self.path, self.reason = path, reason
        super().__init__(f"{path}: {reason}" if path else reason)

    def below(self, parent: str) -> ConversionError:
        """Return the same error, seen from the message that holds the field `parent`."""
        separator = "" if not self.path or self.path.startswith("[") else "."
        return ConversionError(f"{parent}{separator}{self.path}", self.reason)


@dataclass(frozen=True, slots=True)
class FieldType:
    """The type of a field.

    Attributes:
        base: primitive (`double`) or message (`geometry_msgs/Point`), without the array part.
        array: whether it holds several.
        size: the exact number of elements, or None.
    """

    base: str
    array: bool = False
    size: int | None = None

    @property
    def message(self) -> Any:
        """The class of the elements when they are messages, else None."""
        return load_type(self.base) if "/" in self.base else None


@cache
def field_types(cls: Any) -> dict[str, FieldType]:
    """Return the fields of a message class and their types."""
    return {name: _parse(text) for name, text in cls.get_fields_and_field_types().items()}


def check_field(cls: Any, name: str) -> FieldType:
    """Return the type of a field.

    Raises:
        ConversionError: the message has no such field.
    """
    known = field_types(cls)
    if name not in known:
        reason = f"{type_name(cls)} has no such field{nearest(name, known)} (it has: {', '.join(known)})"
        raise ConversionError(name, reason)
    return known[name]


def primitive(kind: FieldType, value: Any) -> Any:
    """Return `value` as rclpy's fields want primitives: floats from integers, sequences as `array.array`.

    Raises:
        ConversionError: the value can't be one.
    """
    try:
        return _sequence(kind, value) if kind.array else _scalar(kind.base, value)
    except (TypeError, ValueError, OverflowError) as error:
        raise ConversionError("", f"{kind.base}{'[]' if kind.array else ''} expected: {error}") from None


def _scalar(base: str, value: Any) -> Any:
    if base in ("float", "double"):
        if isinstance(value, (str, bool)):
            raise TypeError(f"got {value!r}")
        return float(value)
    if base == "boolean":
        if not isinstance(value, (bool, np.bool_)):
            raise TypeError(f"got {value!r}")
        return bool(value)
    if base == "octet":
        return bytes([value]) if isinstance(value, int) else value
    if base.startswith(("string", "wstring")):
        if not isinstance(value, str):
            raise TypeError(f"got {value!r}")
        return value
    if isinstance(value, (bool, float, str)) or int(value) != value:
        raise TypeError(f"got {value!r}")
    return int(value)


def _sequence(kind: FieldType, value: Any) -> Any:
    code = _CODES.get(kind.base)
    if isinstance(value, str):
        raise TypeError(f"got {value!r}")
    if code is None:
        return [_scalar(kind.base, item) for item in value]
    if kind.size is not None:
        return np.asarray(value, dtype=code)
    if isinstance(value, array.array) and value.typecode == code:
        return value
    result = array.array(code)
    if isinstance(value, (bytes, bytearray, memoryview)) and result.itemsize == 1:
        result.frombytes(value)
    else:
        wanted = np.asarray(value)
        if wanted.size and (wanted.dtype.kind not in "iufb" or (wanted.dtype.kind == "f" and code not in "fd")):
            raise TypeError(f"got elements of type {wanted.dtype}")
        flat = np.ascontiguousarray(wanted, dtype=code).reshape(-1)
        if code not in "fd" and not np.array_equal(flat, wanted.reshape(-1)):
            raise OverflowError("an element is out of range")
        result.frombytes(memoryview(flat.data).cast("B") if flat.size else b"")
    return result


def _parse(text: str) -> FieldType:
    match = _ARRAY.match(text)
    if match is None:
        return FieldType(text)
    size = int(match["size"]) if match["size"] else None
    return FieldType(match["item"] or match["fixed"], True, size)
