"""What was shown to an arm or a hand: joint states and poses by name, kept in a file of the project.

    right:
      above_crate:
        state: {panda_joint1: 0.1, ...}
      look:
        pose: {position: [0.5, 0, 0.4], quaternion: [0, 1, 0, 0], frame: world}

The first level names arms and hands as the project does; quaternions are w x y z. The file may be written by hand.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping
from pathlib import Path

import yaml
from pydantic import RootModel, TypeAdapter

from grip_bt.base.errors import DocumentError
from grip_bt.base.failures import NameTakenError
from grip_bt.base.files import replace_text
from grip_bt.base.values import JointState, Pose
from grip_bt.base.yaml.models import Settings, document_error, validated
from grip_bt.base.yaml.tree import YamlMapping, parse, read_file


class TaughtPose(Settings):
    """A pose in a frame."""

    position: tuple[float, float, float]
    """Of the arm's hand [m]."""
    quaternion: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    """Its orientation, w x y z."""
    frame: str = "world"
    """The frame that it is given in."""


class TaughtEntry(Settings):
    """A joint state, or a pose."""

    state: dict[str, float] | None = None
    """Joint -> position [rad or m]."""
    pose: TaughtPose | None = None
    """In place of `state`."""


class TaughtFile(RootModel[dict[str, dict[str, TaughtEntry]]]):
    """Arm or hand of the project -> name -> what was taught."""


class TaughtStates:
    """Named joint states and poses, by part of the robot. Safe to use from any thread.

    Args:
        file: where they are kept; None for this run only. A file that isn't there is written with the first entry.

    Raises:
        DocumentError: the file is wrong.
    """

    def __init__(self, file: Path | None = None):
        self._file, self._lock = file, threading.Lock()
        self._parts: dict[str, dict[str, JointState | Pose]] = {}
        if file is not None and file.is_file():
            for part, entries in _read(file).items():
                self._parts[part] = {name: _value(entry, f"{part}/{name}", file) for name, entry in entries.items()}

    def parts(self) -> tuple[str, ...]:
        """Return the arms and hands that something was taught to."""
        with self._lock:
            return tuple(self._parts)

    def of(self, part: str) -> Mapping[str, JointState | Pose]:
        """Return what was taught to a part: name -> joint state or pose."""
        with self._lock:
            return dict(self._parts.get(part, {}))

    def states(self, part: str) -> dict[str, JointState]:
        """Return the joint states that were taught to a part."""
        return {name: value for name, value in self.of(part).items() if isinstance(value, JointState)}

    def put(self, part: str, name: str, value: JointState | Pose, taken: Mapping[str, object]) -> None:
        """Add or replace an entry, and write the file.

        Args:
            taken: names that mean something else already, such as those of the robot's description.

        Raises:
            NameTakenError: the name is one of `taken`.
            ValueError: the name isn't a word.
        """
        if not name.isidentifier():
            raise ValueError(f"a taught name is a word of letters, digits and _, not {name!r}")
        if name in taken:
            raise NameTakenError(f"{part}: {name!r} is a state of the robot's description; choose another name")
        with self._lock:
            self._parts.setdefault(part, {})[name] = value
            if self._file is not None:
                _write(self._file, self._parts)


def _read(file: Path) -> dict[str, dict[str, TaughtEntry]]:
    tree = parse(read_file(file), str(file))
    if not isinstance(tree, YamlMapping):
        raise document_error([("a mapping of names to what was taught is expected", tree.line, tree.column)], str(file))
    return validated(TypeAdapter(TaughtFile), tree, str(file)).root


def _value(entry: TaughtEntry, where: str, file: Path) -> JointState | Pose:
    if (entry.state is None) == (entry.pose is None):
        raise DocumentError(f"{where} has either a `state:` or a `pose:`", str(file))
    try:
        if entry.pose is not None:
            return Pose(entry.pose.position, entry.pose.quaternion, entry.pose.frame)
        return JointState.from_mapping(entry.state or {})
    except ValueError as error:
        raise DocumentError(f"{where}: {error}", str(file)) from None


def _write(file: Path, parts: Mapping[str, Mapping[str, JointState | Pose]]) -> None:
    """Write all of it in one go: a run that is killed leaves the old file or the new one."""
    data = {part: {name: _entry(value) for name, value in entries.items()} for part, entries in parts.items()}
    text = yaml.safe_dump(data, default_flow_style=None, width=math.inf, sort_keys=False, allow_unicode=True)
    replace_text(file, f"# What was taught to arms and hands; see docs/commanders.md.\n{text}")


def _entry(value: JointState | Pose) -> dict[str, object]:
    if isinstance(value, JointState):
        return {"state": value.as_mapping()}
    pose = {"position": value.position.tolist(), "quaternion": value.quaternion.tolist(), "frame": value.frame}
    return {"pose": pose}
