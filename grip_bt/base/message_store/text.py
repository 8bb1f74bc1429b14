"""Values and messages as YAML that people read and change, and back."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
import yaml

from grip_bt.base.errors import DocumentError, GripError
from grip_bt.base.message_store.files import read_joint_states, read_poses, read_trajectories
from grip_bt.base.values import JointState, Pose
from grip_bt.base.yaml.tree import parse, to_data

_EDITABLE = 2000
"""Largest number of values in a message that is written as text."""


def text_of(value: object, digits: int | None = None) -> str:
    """Return a joint state, a pose, a robot pose or a message as YAML; empty for what isn't changed by hand.

    Args:
        digits: behind the point of positions and orientations; all by default.
    """
    match value:
        case JointState():
            data: object = _numbers(value.names, value.position, digits)
        case Pose():
            data = {"reference_frame": value.frame, **_pose_data(value, digits)}
        case dict() if value and all(isinstance(part, Pose) for part in value.values()):
            data = {"reference_frame": next(iter(value.values())).frame} | {
                n: _pose_data(p, digits) for n, p in value.items()
            }
        case _:
            data = plain_of(value) if fields_of(value) is not None else None
    if data is None:
        return ""
    return str(yaml.safe_dump(data, sort_keys=False, allow_unicode=True))


def value_of(store: str, name: str, text: str, states: Mapping[str, JointState] | None = None) -> object:
    """Return what a text says.

    Args:
        store: those of a project's files take what these hold; any other a mapping of a message's fields.
        states: what the way-points of a trajectory can name.

    Raises:
        DocumentError: it says something else, with the place.
    """
    data = to_data(parse(text, name))
    if store == "trajectories" and isinstance(data, list):
        return _read(lambda source, text: read_trajectories(source, states or {}, text), name, text)
    if not isinstance(data, dict) or not data:
        raise DocumentError("expected a mapping, such as `joint_1: 0.5` or a message's fields", name, 1, 1)
    if store not in ("joint_states", "poses", "robot_poses"):
        return data
    if store == "joint_states":
        return _read(read_joint_states, name, text)
    try:
        return _read(lambda source, text: read_poses(source, text)[store == "robot_poses"], name, text)
    except KeyError:
        wanted = "expected one pose, with position and orientation"
        if store == "robot_poses":
            wanted = "expected the poses of end effectors, each with position and orientation"
        raise GripError(f"{name}: {wanted}") from None


def _read(read: Callable[[str, str], Mapping[str, object]], name: str, text: str) -> object:
    """Read a text as what a file of a project holds under one name."""
    lines = "".join(f"  {line}\n" for line in text.splitlines())
    try:
        return read(name, f"value:\n{lines}")["value"]
    except DocumentError as error:
        line = max(1, error.line - 1) if error.line else None
        column = max(1, error.column - 2) if error.column else None
        raise DocumentError(error.message.removeprefix("value").lstrip("/: "), name, line, column) from None


def fields_of(message: object) -> tuple[str, ...] | None:
    """Return the names of a ROS message's fields, None for what is no message."""
    asked = getattr(message, "get_fields_and_field_types", None)
    return None if asked is None else tuple(asked())


def plain_of(message: object) -> object:
    """Return a message as mappings, lists and plain values, or None when that is too much to be changed by hand."""
    count = 0

    def plain(part: Any) -> object:
        nonlocal count
        if (names := fields_of(part)) is not None:
            return {name: plain(getattr(part, name)) for name in names}
        if isinstance(part, bytes | bytearray):
            part = list(part)
        if hasattr(part, "tolist"):
            count += len(part) if np.ndim(part) else 1
            if count > _EDITABLE:
                raise OverflowError
            return part.tolist()
        if isinstance(part, list | tuple):
            return [plain(each) for each in part]
        count += 1
        if count > _EDITABLE:
            raise OverflowError
        return part

    try:
        return plain(message)
    except OverflowError:
        return None


def _pose_data(pose: Pose, digits: int | None) -> dict[str, object]:
    return {
        "position": _numbers("xyz", pose.position, digits),
        "orientation": _numbers("xyzw", np.roll(pose.quaternion, -1), digits),
    }


def _numbers(names: Iterable[str], values: object, digits: int | None) -> dict[str, float]:
    rows = zip(names, np.asarray(values), strict=True)
    return {str(name): float(number) if digits is None else round(float(number), digits) for name, number in rows}
