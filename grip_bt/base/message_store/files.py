"""Named joint states, poses, robot poses and trajectories as YAML, in the format that the first GRIP had; messages too.

    joint states:  above_bin: {joint_1: 1.49, joint_2: 0.48}
    poses:         bin: {reference_frame: world, position: {x: 0, y: 0, z: 0.1}, orientation: {r: 0, p: 0, y: 0}}
    robot poses:   pinch: {reference_frame: palm, thumb: {position: ..., orientation: ...}, index: {...}}
    trajectories:  there: [{name: above_bin, interpolate_time: 0.5, pause_time: 0.2}, ...]

Numbers keep the precision of the file, and are written unrounded. An orientation is `{r, p, y}` (about the fixed x, y,
z [rad]) or `{x, y, z, w}`. A file may be any YAML; the first format's own reader took much less.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, TypeVar

import numpy as np
from pydantic import AfterValidator, Field, TypeAdapter

from grip_bt.base.errors import DocumentError, nearest
from grip_bt.base.values import JointState, Pose, Trajectory
from grip_bt.base.values.pose import quaternion_of
from grip_bt.base.yaml.models import Settings, check_model, document_error, validated
from grip_bt.base.yaml.tree import YamlEntry, YamlMapping, YamlValue, parse, read_file, to_data

T = TypeVar("T")
Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]


def _keys(said: str, *allowed: str) -> AfterValidator:
    def check(numbers: dict[str, float]) -> dict[str, float]:
        if set(numbers) not in [set(keys) for keys in allowed]:
            raise ValueError(said)
        return numbers

    return AfterValidator(check)


class _PosePart(Settings):
    position: Annotated[dict[str, Number], _keys("a position has x, y and z [m]", "xyz")]
    orientation: Annotated[dict[str, Number], _keys("an orientation has r, p, y [rad], or x, y, z, w", "rpy", "xyzw")]

    def pose(self, frame: str) -> Pose:
        """Return it in a frame."""
        given = self.orientation
        turn = quaternion_of(*(given[k] for k in "rpy")) if "r" in given else [given[k] for k in "wxyz"]
        return Pose([self.position[k] for k in "xyz"], turn, frame)


class _WayPoint(Settings):
    name: str
    interpolate_time: Number
    pause_time: Number


_JOINTS = TypeAdapter(dict[str, Annotated[dict[str, Number], Field(min_length=1)]])
_WAY_POINTS = TypeAdapter(dict[str, Annotated[list[_WayPoint], Field(min_length=1)]])


def read_joint_states(path: Path | str, text: str | None = None) -> dict[str, JointState]:
    """Read named joint states. Raises DocumentError: the file is wrong; with the place."""
    found = validated(_JOINTS, _tree(path, text), str(path))
    return {name: JointState.from_mapping(positions) for name, positions in found.items()}


def read_poses(path: Path | str, text: str | None = None) -> tuple[dict[str, Pose], dict[str, dict[str, Pose]]]:
    """Read named poses, and robot poses, which hold the poses of several end effectors.

    Raises:
        DocumentError: the file is wrong; with the place.
    """
    poses: dict[str, Pose] = {}
    several: dict[str, dict[str, Pose]] = {}
    for name, entry in _tree(path, text).entries.items():
        parts = dict(entry.value.entries) if isinstance(entry.value, YamlMapping) else {}
        frame = parts.pop("reference_frame", None)
        said = None if frame is None else to_data(frame.value)
        if not isinstance(said, str) or not said:
            raise _error(path, frame or entry, f"{name}: the key 'reference_frame' is missing, or names no frame")
        if parts.keys() & _PosePart.model_fields.keys():
            place = YamlMapping(line=entry.line, column=entry.column, entries=parts)
            poses[name] = _pose(place, name, said, str(path))
        elif parts:
            several[name] = {k: _pose(part.value, f"{name}/{k}", said, str(path)) for k, part in parts.items()}
        else:
            raise _error(path, entry, f"{name}: neither a pose (position, orientation) nor poses of end effectors")
    return poses, several


def read_trajectories(
    path: Path | str, states: Mapping[str, JointState], text: str | None = None
) -> dict[str, Trajectory]:
    """Read named trajectories, whose way-points are named joint states.

    A way-point is reached `interpolate_time` after the one before and, with a `pause_time`, kept that long. The first
    is where the trajectory starts; joints are in alphabetical order.

    Raises:
        DocumentError: the file is wrong, or names a joint state that isn't there; with the place.
    """
    tree = _tree(path, text)
    return {
        name: _trajectory(path, tree.entries[name], points, states)
        for name, points in validated(_WAY_POINTS, tree, str(path)).items()
    }


def _error(path: Path | str, entry: YamlEntry, reason: str) -> DocumentError:
    return DocumentError(reason, str(path), entry.line, entry.column)


def _tree(path: Path | str, text: str | None) -> YamlMapping:
    text = read_file(path) if text is None else text
    if not any(line.strip() and not line.strip().startswith("#") for line in text.splitlines()):
        return YamlMapping()  # a file that waits for its first entry
    tree = parse(text, str(path))
    if not isinstance(tree, YamlMapping):
        raise DocumentError("expected a mapping from names to values", str(path), tree.line, tree.column)
    return tree


def _pose(value: YamlValue, name: str, frame: str, source: str) -> Pose:
    found, faults = check_model(value, _PosePart, name)
    if found is None:
        raise document_error([(f"{name}: {said}", line, column) for said, line, column in faults], source)
    try:
        return found.pose(frame)
    except ValueError as error:
        raise DocumentError(f"{name}: {error}", source, value.line, value.column) from None


def _trajectory(
    path: Path | str, entry: YamlEntry, points: Iterable[_WayPoint], states: Mapping[str, JointState]
) -> Trajectory:
    name = entry.key
    names: tuple[str, ...] = ()
    times: list[float] = []
    rows: list[np.ndarray] = []
    now = 0.0
    for point in points:
        if point.name not in states:
            raise _error(path, entry, f"{name}: there is no joint state {point.name!r}{nearest(point.name, states)}")
        state = states[point.name]
        names = names or tuple(sorted(state.names))
        if set(state.names) != set(names):
            raise _error(path, entry, f"{name}: all way-points have the same joints; the first has {', '.join(names)}")
        if times and point.interpolate_time <= 0:
            raise _error(path, entry, f"{name}: 'interpolate_time' is more than 0 [s]")
        now = now + point.interpolate_time if times else 0.0
        for moment in (now, now + point.pause_time) if point.pause_time > 0 else (now,):
            times.append(moment)
            rows.append(state.ordered(names))
        now = times[-1]
    return Trajectory(names, np.array(times), np.array(rows))
