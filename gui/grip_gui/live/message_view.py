"""What a page shows of a ROS message."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from grip_bt.base.errors import GripError
from grip_bt.base.message_store.text import fields_of
from grip_bt.base.values import CameraInfo, Pose
from grip_bt.ros.convert import from_message
from grip_bt.ros.convert_values import depth_from_message
from grip_bt.task.catalog.ros_config import MESSAGES
from grip_gui.runs.values import ROWS, value_view
from grip_gui.wire.runs import ValueView

_DEPTHS = ("32FC1", "16UC1")


def message_view(type_name: str, message: object) -> ValueView:
    """Return what a page shows of a message, as the value that a task would get of it where there is one."""
    value = _value(type_name, message)
    if value is not None:
        return value_view(type_name, value)
    if fields_of(message) is None:
        return value_view(type_name, message)
    rows = [[path, text] for path, text in _flat(message, "")]
    shown = rows[:ROWS] + ([["...", "there is more"]] if len(rows) > ROWS else [])
    return ValueView(type=type_name, text=", ".join(f"{p}: {t}" for p, t in rows[:3]), rows=shown)


def _value(type_name: str, message: Any) -> Any:
    wanted = next((name for name, ros in MESSAGES.items() if ros == type_name), None)
    try:
        if wanted == "Image" and message.encoding in _DEPTHS:
            # Only the picture is shown, for which any camera of this size will do.
            info = CameraInfo(message.width, message.height, np.eye(3), Pose((0, 0, 0)))
            return depth_from_message(message, info)
        return None if wanted is None else from_message(message, wanted)
    except (GripError, ValueError):
        return None  # it is shown as the message that it is


def _flat(part: object, path: str) -> Iterator[tuple[str, str]]:
    if (names := fields_of(part)) is not None:
        for name in names:
            yield from _flat(getattr(part, name), f"{path}.{name}" if path else name)
    elif isinstance(part, list | tuple) and part and fields_of(part[0]) is not None:
        for at, each in enumerate(part):
            yield from _flat(each, f"{path}[{at}]")
    else:
        yield path, _short(part)


def _short(part: object) -> str:
    if isinstance(part, float):
        return f"{part:.6g}"
    if hasattr(part, "__len__") and not isinstance(part, str) and len(part) > 12:
        return f"{len(part)} elements"
    return str(part.tolist() if hasattr(part, "tolist") else part)[:300]
