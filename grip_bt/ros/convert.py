"""GRIP's values to and from ROS messages: the only place where units, frames and quaternion order change.

What has a counterpart in ROS (poses, clouds, images, joint states, trajectories) has a function of its own. Everything
else goes by the names of its fields: a dataclass fills the fields of the same name, and is made from them.
"""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from typing import Any, get_args, get_origin

import numpy as np

from grip_bt.base import values
from grip_bt.base.types import BUILTINS, VALUES, Type, parse_type
from grip_bt.base.values import CameraInfo, DepthImage, Image, JointState, PointCloud, Pose, Trajectory

from . import convert_values as turn
from .client.types import (
    ConversionError,
    FieldType,
    InterfaceType,
    Message,
    check_field,
    field_types,
    primitive,
    type_name,
)

_CONVERSIONS: dict[tuple[type, str], tuple[Callable[[Any], Message], Callable[[Any], object] | None]] = {
    (Pose, "geometry_msgs/msg/Pose"): (turn.pose_to_message, turn.pose_from_message),
    (Pose, "geometry_msgs/msg/PoseStamped"): (turn.pose_to_stamped, turn.pose_from_stamped),
    (Pose, "geometry_msgs/msg/Transform"): (turn.pose_to_transform, turn.pose_from_message),
    (Pose, "geometry_msgs/msg/TransformStamped"): (
        turn.pose_to_transform_stamped,
        turn.pose_from_stamped,
    ),
    (JointState, "sensor_msgs/msg/JointState"): (turn.joints_to_message, turn.joints_from_message),
    (Trajectory, "trajectory_msgs/msg/JointTrajectory"): (
        turn.trajectory_to_message,
        turn.trajectory_from_message,
    ),
    (PointCloud, "sensor_msgs/msg/PointCloud2"): (turn.cloud_to_message, turn.cloud_from_message),
    (Image, "sensor_msgs/msg/Image"): (turn.image_to_message, turn.image_from_message),
    (DepthImage, "sensor_msgs/msg/Image"): (turn.depth_to_message, None),  # needs the camera's geometry too
    (CameraInfo, "sensor_msgs/msg/CameraInfo"): (turn.camera_to_message, turn.camera_from_message),
}
"""What has a counterpart in ROS: value, message -> to the message, from the message."""


def to_message(value: object, cls: InterfaceType) -> Message:
    """Return a message of class `cls` that holds `value`.

    Args:
        value: a message of `cls`, a value, a dataclass, or a mapping of fields; a primitive for a message such as
            std_msgs/Float64, whose only field is `data`. Fields of a dataclass that the message lacks are left out.

    Raises:
        ConversionError: the value doesn't fit, with the field where it doesn't.
    """
    if isinstance(value, cls):
        return value
    special = _CONVERSIONS.get((type(value), type_name(cls)))
    if special is not None:
        return special[0](value)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        names = [f.name for f in dataclasses.fields(value) if f.name in field_types(cls)]
        if not names:
            raise ConversionError("", f"a {type(value).__name__} has no field in common with {type_name(cls)}")
        value = {name: getattr(value, name) for name in names if getattr(value, name) is not None}
    elif not isinstance(value, Mapping):
        if list(field_types(cls)) != ["data"]:
            raise ConversionError("", f"a {type(value).__name__} can't be made a {type_name(cls)}")
        value = {"data": value}
    message = cls()
    for name, item in value.items():
        kind = check_field(cls, name)
        try:
            setattr(message, name, _field(kind, item))
        except ConversionError as error:
            raise error.below(name) from None
        except AssertionError as error:  # rclpy's own check of bounds and ranges
            raise ConversionError(name, str(error)) from None
    return message


def from_message(message: Any, declared: Any = Any) -> Any:
    """Return a message, or a field of one, as the declared type.

    Args:
        message: a message, a primitive, or a sequence of either.
        declared: the name of a type (`list[Grasp]`) or a Python type; `Any` or a ROS type leave it as it is.

    Raises:
        ConversionError: it can't be one, with the field that doesn't fit.
        ValueError: the declared type isn't one.
    """
    wanted = python_type(declared) if isinstance(declared, str) else declared
    if wanted is Any:
        return message
    origin, arguments = get_origin(wanted) or wanted, get_args(wanted)
    if origin in (types.UnionType, typing.Union):
        wanted = next(a for a in arguments if a is not type(None))
        return from_message(message, wanted)
    if origin is list or origin is tuple:
        if isinstance(message, str) or not hasattr(message, "__len__"):
            raise ConversionError("", f"a sequence expected, got {_describe(message)}")
        inner = arguments[0] if arguments else Any
        return origin(each(message, lambda item: from_message(item, inner)))
    if origin is np.ndarray:
        return np.asarray(message)
    if wanted in (bool, int, float, str):
        return _builtin(message, wanted)
    if not hasattr(message, "get_fields_and_field_types"):
        if isinstance(message, wanted):
            return message
        raise ConversionError("", f"{_describe(message)} can't be made a {wanted.__name__}")
    _, special = _CONVERSIONS.get((wanted, type_name(type(message))), (None, None))
    try:
        return special(message) if special is not None else _dataclass(message, wanted)
    except ValueError as error:  # values check themselves
        raise ConversionError("", str(error)) from None


def _field(kind: FieldType, value: object) -> Any:
    cls = kind.message
    if cls is None:
        return primitive(kind, value)
    if not kind.array:
        return to_message(value, cls)
    if isinstance(value, (str, Mapping)) or not isinstance(value, Sequence):
        raise ConversionError("", f"a list of {kind.base} expected, got {_describe(value)}")
    return each(value, lambda item: to_message(item, cls))


def each(items: Iterable[object], turn: Callable[[Any], object]) -> list[object]:
    """Turn each item, and say which one can't be turned."""
    turned = []
    for index, item in enumerate(items):
        try:
            turned.append(turn(item))
        except ConversionError as error:
            raise error.below(f"[{index}]") from None
    return turned


def _builtin(message: Any, wanted: type) -> object:
    if list(getattr(message, "get_fields_and_field_types", dict)()) == ["data"]:
        message = message.data
    if wanted is float and isinstance(message, int) and not isinstance(message, bool):
        return float(message)
    if not isinstance(message, wanted) or (wanted is int and isinstance(message, bool)):
        raise ConversionError("", f"{_describe(message)} isn't a {wanted.__name__}")
    return message


_hints = cache(typing.get_type_hints)


def _dataclass(message: Message, cls: Any) -> object:
    if not hasattr(cls, "__dataclass_fields__"):
        raise ConversionError("", f"{_describe(message)} can't be made a {cls.__name__}")
    found = {}
    for field in dataclasses.fields(cls):
        if field.name in field_types(message.__class__):
            try:
                found[field.name] = from_message(getattr(message, field.name), _hints(cls)[field.name])
            except ConversionError as error:
                raise error.below(field.name) from None
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            reason = f"{_describe(message)} lacks the field {field.name!r} that a {cls.__name__} needs"
            raise ConversionError("", reason)
    return cls(**found)


def _describe(value: object) -> str:
    return type_name(type(value)) if hasattr(value, "get_fields_and_field_types") else f"a {type(value).__name__}"


_KNOWN: dict[str, Any] = {"Any": Any, "None": None, "bool": bool, "int": int, "float": float, "str": str}
_KNOWN |= {"bytes": bytes, **{name: getattr(values, name) for name in VALUES}}
assert set(BUILTINS) <= _KNOWN.keys()


@cache
def python_type(text: str) -> Any:
    """Return the Python type that a declared type names; `Any` for a ROS type, which stays a message.

    Raises:
        ValueError: it isn't a type.
    """
    return _build(parse_type(text))


def _build(declared: Type) -> Any:
    inner = Any if declared.item is None else _build(declared.item)
    if declared.name == "list":
        made: Any = list[inner]  # type: ignore[valid-type]
    elif declared.name == "dict":
        made = dict[str, inner]  # type: ignore[valid-type]
    else:
        made = _KNOWN.get(declared.name, Any)
    return made | None if declared.optional and made is not Any else made
