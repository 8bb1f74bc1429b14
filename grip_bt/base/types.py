"""The types of ports, parameters and variables: reading their names, what may flow where, what a value must be.

A type is the name of a value of `grip_bt.base.values`, a builtin (`bool int float str bytes`), `list[T]`,
`dict[str, T]`, `T | None`, a ROS type (`geometry_msgs/msg/PoseStamped`) or `Any`. Values are recognised by the names
of their classes, so nothing heavy is imported.
"""

from __future__ import annotations

import ast
import re
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from math import isfinite
from typing import Any, TypeAlias

from grip_bt.base.errors import listing, nearest

Value: TypeAlias = Any
"""A value of a variable, a port or a parameter, of whatever type the document declares."""
JsonObject: TypeAlias = Mapping[str, Any]
"""An object of JSON, as it was read: an event or a command of another process, a row of results."""
VALUES = (
    *("CameraInfo", "DepthImage", "Failure", "Grasp", "Image", "JointState", "PathConstraint", "Plan"),
    *("PointCloud", "Pose", "RgbdFrame", "Trajectory", "WayPoint"),
)
"""Class names of `grip_bt.base.values`."""
BUILTINS = ("bool", "int", "float", "str", "bytes")
_ROS = re.compile(r"[a-z][a-z0-9_]*/(msg|srv|action)/[A-Z][A-Za-z0-9_]*")
_DEEPEST = 20
_LONGEST = 30_000


@dataclass(frozen=True, slots=True)
class Type:
    """A type expression.

    Attributes:
        name: a value's, a builtin's or a ROS type's name, `list`, `dict`, `None` or `Any`; of `T | None`, T's name.
        item: the type of the items of a `list` or of the values of a `dict`.
        optional: whether None is allowed too.
    """

    name: str
    item: Type | None = field(default=None)
    optional: bool = False

    def __str__(self) -> str:
        key = "str, " if self.name == "dict" else ""
        inner = f"[{key}{self.item}]" if self.item is not None else ""
        return f"{self.name}{inner}" + (" | None" if self.optional else "")


ANY = Type("Any")


@lru_cache(maxsize=4096)
def parse_type(text: str) -> Type:
    """Read a type expression; ValueError where it isn't one; the message names the nearest type."""
    if len(text) > _LONGEST:
        raise ValueError(f"{text[:40]!r}... is longer than {_LONGEST} characters, which no type is")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(text.strip() or "_", mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError(f"{text[:40]!r} isn't a type{_unknown('')}") from None
    return _type(tree, text, 0)


def _type(node: ast.expr, text: str, depth: int) -> Type:
    if depth > _DEEPEST:
        raise ValueError(f"{text[:40]!r}... is nested deeper than {_DEEPEST} types")
    match node:
        case ast.BinOp(op=ast.BitOr()):
            one, other = _type(node.left, text, depth + 1), _type(node.right, text, depth + 1)
            if "None" not in (one.name, other.name) or one.name == other.name:
                raise ValueError(f"{text!r} isn't a type: the only union is `T | None`")
            kept = other if one.name == "None" else one
            return Type(kept.name, kept.item, optional=True)
        case ast.Subscript(value=ast.Name(id="list"), slice=item):
            return Type("list", _type(item, text, depth + 1))
        case ast.Subscript(value=ast.Name(id="dict"), slice=ast.Tuple(elts=[ast.Name(id="str"), item])):
            return Type("dict", _type(item, text, depth + 1))
        case ast.Subscript(value=ast.Name(id="dict")):
            raise ValueError(f"{text!r} isn't a type: a dict is written `dict[str, T]`")
    name = ast.unparse(node).replace(" / ", "/")
    if name in ("list", "dict"):
        return Type(name, ANY)
    if name not in ("Any", "None", *VALUES, *BUILTINS) and not _ROS.fullmatch(name):
        raise ValueError(f"unknown type {name if text.strip() else ''!r}{_unknown(name)}")
    return Type(name)


def _unknown(name: str) -> str:
    known = (*VALUES, *BUILTINS, "list", "dict", "Any")
    return (
        f"{nearest(name, known)} (available: {listing(known)}, T | None, and ROS types such as sensor_msgs/msg/Image)"
    )


def is_assignable(source: Type | str, target: Type | str) -> bool:
    """Tell whether a value of type `source` may be put where `target` is wanted.

    The same type may; an int where a float is wanted; a T where `T | None` is; anything from and to `Any`, which is
    checked when the value is there. Values can't be changed, so lists and dicts follow their items.
    """
    source = parse_type(source) if isinstance(source, str) else source
    target = parse_type(target) if isinstance(target, str) else target
    if source is target or "Any" in (source.name, target.name):
        return True
    if source.name == "None":
        return target.optional or target.name == "None"
    if source.optional and not target.optional:
        return False
    if source.name != target.name:
        return (source.name, target.name) == ("int", "float")
    if source.item is None or target.item is None:
        return True
    return is_assignable(source.item, target.item)


def check_value(type_: Type | str, value: Any) -> str | None:
    """Return why a value isn't of a type, None when it is."""
    type_ = parse_type(type_) if isinstance(type_, str) else type_
    return _reason(type_, value, "")


_PYTHON: dict[str, tuple[type, ...]] = {
    "bool": (bool,),
    "int": (int,),
    "float": (float, int),
    "str": (str,),
    "bytes": (bytes,),
    "list": (list, tuple),
    "dict": (Mapping,),
}


def _reason(type_: Type, value: Any, where: str) -> str | None:
    if type_.name == "Any" or (value is None and (type_.optional or type_.name == "None")):
        return None
    if type_.name == "Pose" and isinstance(value, Mapping):
        return _reason_of_pose(value, where)
    if not _is_a(type_.name, value):
        shown = repr(value)
        shown = shown if len(shown) <= 40 else shown[:37] + "..."
        at = f"{where} is" if where else "is"
        return f"{at} {shown}, a {type(value).__name__}, not a {type_}"
    if type_.item is None or type_.item.name == "Any":
        return None
    if type_.name == "list":
        pairs = ((f"{where}[{i}]", item) for i, item in enumerate(value))
    else:
        for key in value:
            if not isinstance(key, str):
                return f"the key {key!r} of {where or 'it'} is a {type(key).__name__}, not a str"
        pairs = ((f"{where}[{key!r}]", item) for key, item in value.items())
    return next((r for at, item in pairs if (r := _reason(type_.item, item, at))), None)


_POSE = {"position": 3, "quaternion": 4}
"""What a pose is written as, besides its `frame`: numbers of each."""


def _reason_of_pose(value: Mapping[str, Any], where: str) -> str | None:
    """Return why a mapping isn't a pose: `{position: [x, y, z], quaternion: [w, x, y, z], frame: world}`."""
    for key, given in value.items():
        at = f"{where}.{key}" if where else f"{key!r} of it"
        if key == "frame" and not isinstance(given, str):
            return f"{at} is {given!r}, not the name of a frame"
        if key not in ("frame", *_POSE):
            return f"{at} isn't a key of a pose (available: position, quaternion, frame){nearest(str(key), _POSE)}"
        if key in _POSE and not _are_numbers(given, _POSE[key]):
            return f"{at} is {given!r}, not {_POSE[key]} numbers"
    if "position" not in value:
        return f"{where or 'it'} is a pose without a `position`"
    return None if any(value.get("quaternion", (1,))) else f"the quaternion of {where or 'it'} has a length of zero"


def _are_numbers(value: object, count: int) -> bool:
    return (
        isinstance(value, list | tuple)
        and len(value) == count
        and all(isinstance(n, int | float) and not isinstance(n, bool) and isfinite(n) for n in value)
    )


def _is_a(name: str, value: object) -> bool:
    if name in _PYTHON:
        fits = isinstance(value, _PYTHON[name])
        return fits and (name == "bool" or not isinstance(value, bool))
    kinds = type(value).__mro__
    if "/" in name:
        package, folder, message = name.split("/")
        return any(k.__name__ == message and k.__module__.startswith(f"{package}.{folder}") for k in kinds)
    return any(k.__name__ == name and k.__module__.startswith("grip_bt.base.values") for k in kinds)
