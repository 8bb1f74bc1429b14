"""Values of runs kept as named messages of the project: what was measured once becomes a place to go to."""

from __future__ import annotations

from typing import Any

import numpy as np

from grip_bt.base.errors import GripError
from grip_bt.base.values import JointState, Pose
from grip_gui.editing.files import TextFile
from grip_gui.project import ProjectFolder

from .changes import set_value
from .kinds import JOINT_STATES, POSES, kind_of

DIGITS = 9
"""Digits after the point: nanometres, which no robot measures."""


class UnrecordableError(GripError):
    """A value has no place among the named messages."""


def record(folder: ProjectFolder, name: str, value: Any) -> str:
    """Put a value into the file of its kind under a name; return the file's path.

    Args:
        folder: the project.
        name: of the message; one of this name is replaced.
        value: a pose or a joint state.

    Raises:
        UnrecordableError: it is something else.
        DocumentError: the file can't be read or written.
    """
    path, data = _written(value)
    file = TextFile(folder.settings_file(path), path)
    text = file.read() if file.path.exists() else kind_of(path).blank
    file.write(set_value(text, [name], data))
    return path


def _written(value: Any) -> tuple[str, dict[str, Any]]:
    match value:
        case Pose():
            return POSES, {
                "reference_frame": value.frame,
                "position": _numbers("xyz", value.position),
                "orientation": _numbers("xyzw", np.roll(value.quaternion, -1)),
            }
        case JointState():
            return JOINT_STATES, _numbers(value.names, value.position)
    raise UnrecordableError(f"a {type(value).__name__} can't be kept by name; poses and joint states can")


def _numbers(names: Any, values: Any) -> dict[str, float]:
    return {str(name): round(float(number), DIGITS) for name, number in zip(names, np.asarray(values), strict=True)}
