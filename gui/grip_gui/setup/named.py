"""Values kept as named messages of the project: what was measured once becomes a place to go to."""

from __future__ import annotations

from grip_bt.base.errors import GripError
from grip_bt.base.message_store.yaml import text_of
from grip_bt.base.values import JointState, Pose
from grip_bt.base.yaml.tree import parse, to_data
from grip_gui.editing.files import TextFile
from grip_gui.project import ProjectFolder

from .changes import set_value
from .kinds import JOINT_STATES, POSES, kind_of

DIGITS = 9
"""Digits after the point of what was measured: nanometres, which no robot measures."""
_FILES: dict[type, str] = {Pose: POSES, JointState: JOINT_STATES}


class UnrecordableError(GripError):
    """A value has no place among the named messages."""


def keep_value(folder: ProjectFolder, name: str, value: object) -> str:
    """Put a pose or a joint state into the file of its kind under a name; return the file's path.

    Raises:
        UnrecordableError: it is something else.
        DocumentError: the file can't be read or written.
    """
    if type(value) not in _FILES:
        raise UnrecordableError(f"a {type(value).__name__} can't be kept by name; poses and joint states can")
    keep_text(folder, _FILES[type(value)], name, text_of(value, DIGITS))
    return _FILES[type(value)]


def keep_text(folder: ProjectFolder, path: str, name: str, text: str) -> None:
    """Put a value that is written as YAML into a file of named messages; one of this name is replaced.

    Raises:
        DocumentError: the file can't be read or written.
    """
    file = TextFile(folder.settings_file(path), path)
    before = file.read() if file.path.exists() else kind_of(path).blank
    file.write(set_value(before, [name], to_data(parse(text))))
