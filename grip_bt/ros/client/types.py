"""Interface types by name, and the fields of messages by their type strings, such as `sequence<double, 3>`."""

from __future__ import annotations

import array
import re
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Any, Protocol, cast

import numpy as np
from rclpy.exceptions import InvalidTopicNameException
from rclpy.validate_full_topic_name import validate_full_topic_name
from rclpy.validate_topic_name import validate_topic_name

from grip_bt.base.errors import GripError, MissingPartError, UnknownNameError, nearest
from grip_bt.ros.interfaces.packages import package_like, search_path


class Message(Protocol):
    """A message, a request, a goal and so on: its fields are those of its interface."""

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        """Return the fields and their types."""

    def __getattr__(self, name: str) -> Any: ...

    def __setattr__(self, name: str, value: object) -> None: ...


class InterfaceType(type):
    """The class of messages, or what names those of a service or an action; for annotations alone."""

    def __call__(cls, **fields: object) -> Message:
        raise NotImplementedError

    def __getattr__(cls, name: str) -> Any:
        raise NotImplementedError


@cache
def load_type(name: str) -> InterfaceType:
    """Return the class of a type such as `sensor_msgs/msg/PointCloud2` or `std_srvs/srv/Trigger`.

    Raises:
        UnknownNameError: its package has no such type.
        MissingPartError: its package isn't importable.
    """
    parts = name.split("/")
    if len(parts) == 2:
        parts.insert(1, "msg")
    if len(parts) != 3:
        raise UnknownNameError("ROS type", name, ("package/msg/Name", "package/srv/Name", "package/action/Name"))
    package, kind, cls = parts
    try:
        module = import_module(f"{package}.{kind}")
    except ImportError as error:
        absent = isinstance(error, ModuleNotFoundError) and error.name == package
        why = package_like(package, search_path()).removeprefix("; ") if absent else str(error)
        what = f"the interface package {package!r} of {name}{why and f' ({why})'}"
        raise MissingPartError(what, "grip interfaces build FOLDER") from None
    try:
        return cast(InterfaceType, getattr(module, cls))
    except AttributeError:
        known = [n for n in vars(module) if n[0].isupper()]
        raise UnknownNameError("ROS type", name, (f"{package}/{kind}/{n}" for n in known)) from None


def load_message(name: str) -> InterfaceType:
    """Return the class of a message, as topics carry them.

    Raises:
        GripError: it is of a service or an action, or there is no such type; see `load_type`.
    """
    if name.count("/") == 2 and name.split("/")[1] != "msg":
        raise GripError(f"{name!r} isn't a message: a topic has a type such as 'sensor_msgs/msg/JointState'")
    return load_type(name)


def check_name(name: str) -> None:
    """Check the name of a topic, a service or an action.

    Raises:
        GripError: ROS knows no such names; it says which it knows.
    """
    try:
        validate_topic_name(name)
        if not name.startswith("~") and "{" not in name:  # only this check sees two slashes in a row
            validate_full_topic_name("/" + name.removeprefix("/"))
    except InvalidTopicNameException:
        allowed = "letters, digits and underscores between slashes, no digit first, such as /camera/image_raw"
        raise GripError(f"{name!r} can't name a topic, a service or an action: {allowed}") from None


def type_name(cls: type) -> str:
    """Return the name of a type's class, such as `std_srvs/srv/Trigger`."""
    package, kind = cls.__module__.split(".")[:2]
    return f"{package}/{kind}/{cls.__name__}"


def constant_name(message: Message, value: int) -> str:
    """Return the name of the constant of a message's type that has a value; empty where none has."""
    names = (name for name in dir(type(type(message))) if name.isupper())
    return next((name for name in names if getattr(message, name, None) == value), "")


_CODES = {"float": "f", "double": "d", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H"}
_CODES |= {"int32": "i", "uint32": "I", "int64": "q", "uint64": "Q"}
_ARRAY = re.compile(r"^(?:sequence<(?P<item>.+?)(?:, (?P<bound>\d+))?>|(?P<fixed>.+?)\[(?P<size>\d+)\])$")


class ConversionError(GripError):
    """A value doesn't fit a message, or a message doesn't fit a value.

    Attributes:
        path: the field, such as `returned_object[2].pose`; empty for the whole.
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
        size: the exact number of elements, or None.
    """

    base: str
    array: bool = False
    size: int | None = None

    @property
    def message(self) -> InterfaceType | None:
        """The class of the elements when they are messages, else None."""
        return load_type(self.base) if "/" in self.base else None


@cache
def field_types(cls: type) -> dict[str, FieldType]:
    """Return the fields of a message class and their types."""
    return {name: _parse(text) for name, text in cast(InterfaceType, cls).get_fields_and_field_types().items()}


def check_field(cls: type, name: str) -> FieldType:
    """Return the type of a field. Raises ConversionError: the message has no such field."""
    known = field_types(cls)
    if name not in known:
        reason = f"{type_name(cls)} has no such field{nearest(name, known)} (it has: {', '.join(known)})"
        raise ConversionError(name, reason)
    return known[name]


def primitive(kind: FieldType, value: object) -> Any:
    """Return `value` as rclpy's fields want primitives: floats from integers, sequences as `array.array`.

    Raises:
        ConversionError: the value can't be one.
    """
    try:
        return _sequence(kind, value) if kind.array else _scalar(kind.base, value)
    except (TypeError, ValueError, OverflowError) as error:
        raise ConversionError("", f"{kind.base}{'[]' if kind.array else ''} expected: {error}") from None


def _scalar(base: str, value: Any) -> Any:
    """Return a primitive as rclpy wants it, which checks the rest when it is set."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool) and base != "boolean":
        raise TypeError(f"got {value!r}")
    if base in ("float", "double") and isinstance(value, int):
        return float(value)
    return bytes([value]) if base == "octet" and isinstance(value, int) else value


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
