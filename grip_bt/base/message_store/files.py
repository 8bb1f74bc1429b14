"""Files of named joint states, poses, robot poses and trajectories, in the format that the first GRIP had.

    joint states:  above_bin: {joint_1: 1.49, joint_2: 0.48}
    poses:         bin: {reference_frame: world, position: {x: 0, y: 0, z: 0.1}, orientation: {r: 0, p: 0, y: 0}}
    robot poses:   pinch: {reference_frame: palm, thumb: {position: ..., orientation: ...}, index: {...}}
    trajectories:  there: [{name: above_bin, interpolate_time: 0.5, pause_time: 0.2}, ...]

Numbers keep the precision of the file. An orientation is `{r, p, y}` (about the fixed x, y, z [rad]) or
`{x, y, z, w}`. A file may be any YAML; the first format's own reader took much less.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grip_bt.base.errors import DocumentError, nearest
from grip_bt.base.values import JointState, Pose, Trajectory
from grip_bt.base.values.pose import quaternion_of
from grip_bt.base.yaml.tree import YamlEntry, YamlList, YamlMapping, YamlScalar, YamlValue, parse, read_file, to_data

_POSE_KEYS = ("position", "orientation")


@dataclass(frozen=True)
class _File:
    source: str
    root: YamlMapping

    def error(self, value: YamlEntry, reason: str) -> DocumentError:
        return DocumentError(reason, self.source, value.line, value.column)


def read_joint_states(path: Path | str, text: str | None = None) -> dict[str, JointState]:
    """Read named joint states.

    Raises:
        DocumentError: the file is wrong; with the place.
    """
    file = _open(path, text)
    return {
        name: JointState.from_mapping(_numbers(file, entry, "joint positions"))
        for name, entry in file.root.entries.items()
    }


def read_poses(path: Path | str, text: str | None = None) -> tuple[dict[str, Pose], dict[str, dict[str, Pose]]]:
    """Read named poses, and robot poses, which hold the poses of several end effectors.

    Raises:
        DocumentError: the file is wrong; with the place.
    """
    file = _open(path, text)
    poses: dict[str, Pose] = {}
    several: dict[str, dict[str, Pose]] = {}
    for name, entry in file.root.entries.items():
        parts = _mapping(file, entry, name).entries
        if "reference_frame" not in parts:
            raise file.error(entry, f"{name}: the key 'reference_frame' is missing")
        frame = to_data(parts["reference_frame"].value)
        if not isinstance(frame, str) or not frame:
            raise file.error(parts["reference_frame"], "reference_frame: expected the name of a frame")
        rest = {key: part for key, part in parts.items() if key != "reference_frame"}
        if set(rest) & set(_POSE_KEYS):
            poses[name] = _pose(file, rest, frame, name, entry)
        elif rest:
            several[name] = {
                key: _pose(file, _mapping(file, part, key).entries, frame, f"{name}/{key}", part)
                for key, part in rest.items()
            }
        else:
            raise file.error(entry, f"{name}: neither a pose (position, orientation) nor poses of end effectors")
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
    file = _open(path, text)
    return {name: _trajectory(file, name, entry, states) for name, entry in file.root.entries.items()}


def _open(path: Path | str, text: str | None) -> _File:
    source = str(path)
    text = read_file(path) if text is None else text
    if not any(line.strip() and not line.strip().startswith("#") for line in text.splitlines()):
        return _File(source, YamlMapping())  # a file that waits for its first entry
    tree = parse(text, source)
    if not isinstance(tree, YamlMapping):
        raise DocumentError("expected a mapping from names to values", source, tree.line, tree.column)
    return _File(source, tree)


def _mapping(file: _File, entry: YamlEntry, name: str) -> YamlMapping:
    if not isinstance(entry.value, YamlMapping):
        raise file.error(entry, f"{name}: expected a mapping")
    return entry.value


def _numbers(file: _File, entry: YamlEntry, what: str) -> dict[str, float]:
    parts = _mapping(file, entry, entry.key).entries
    if not parts:
        raise file.error(entry, f"{entry.key}: expected {what}, such as {{joint_1: 0.5}}")
    return {key: _number(file, part) for key, part in parts.items()}


def _number(file: _File, entry: YamlEntry) -> float:
    value = entry.value.value if isinstance(entry.value, YamlScalar) else None
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise file.error(entry, f"{entry.key}: expected a number, not {value!r}")
    return float(value)


def _pose(file: _File, parts: Mapping[str, YamlEntry], frame: str, name: str, at: YamlEntry) -> Pose:
    unknown = [key for key in parts if key not in _POSE_KEYS]
    if unknown:
        hint, allowed = nearest(unknown[0], _POSE_KEYS), ", ".join(("reference_frame", *_POSE_KEYS))
        raise file.error(parts[unknown[0]], f"{name}: unknown key {unknown[0]!r}{hint} (a pose has: {allowed})")
    for key in _POSE_KEYS:
        if key not in parts:
            raise file.error(at, f"{name}: the key {key!r} is missing")
    position = _numbers(file, parts["position"], "x, y, z")
    orientation = _numbers(file, parts["orientation"], "r, p, y or x, y, z, w")
    if set(position) != {"x", "y", "z"}:
        raise file.error(parts["position"], f"{name}: a position has x, y and z [m]")
    if set(orientation) == {"r", "p", "y"}:
        quaternion: tuple[float, ...] = quaternion_of(orientation["r"], orientation["p"], orientation["y"])
    elif set(orientation) == {"x", "y", "z", "w"}:
        quaternion = tuple(orientation[k] for k in "wxyz")
    else:
        raise file.error(parts["orientation"], f"{name}: an orientation has r, p, y [rad], or x, y, z, w")
    try:
        return Pose(np.array([position[k] for k in "xyz"]), quaternion, frame)
    except ValueError as error:
        raise file.error(parts["orientation"], f"{name}: {error}") from None


_POINT = ("name", "interpolate_time", "pause_time")


def _trajectory(file: _File, name: str, entry: YamlEntry, states: Mapping[str, JointState]) -> Trajectory:
    points = list(_points(file, name, entry.value, entry, states))
    names = tuple(sorted(points[0][0].names))
    times: list[float] = []
    rows: list[np.ndarray] = []
    now = 0.0
    for state, reached, pause, at in points:
        if set(state.names) != set(names):
            raise file.error(at, f"{name}: all way-points have the same joints; the first has {', '.join(names)}")
        if times and reached <= 0:
            raise file.error(at, f"{name}: 'interpolate_time' is more than 0 [s]")
        now = now + reached if times else 0.0
        times.append(now)
        rows.append(state.ordered(names))
        if pause > 0:
            now += pause
            times.append(now)
            rows.append(rows[-1])
    return Trajectory(names, np.array(times), np.array(rows))


def _points(
    file: _File, name: str, value: YamlValue, at: YamlEntry, states: Mapping[str, JointState]
) -> Iterator[tuple[JointState, float, float, YamlEntry]]:
    if not isinstance(value, YamlList) or not value.entries:
        raise file.error(at, f"{name}: expected a list of way-points {{{', '.join(_POINT)}}}")
    for item in value.entries:
        parts = _mapping(file, item, name).entries
        if set(parts) != set(_POINT):
            raise file.error(item, f"{name}: a way-point has exactly {', '.join(_POINT)}")
        said = parts["name"].value
        wanted = str(said.value) if isinstance(said, YamlScalar) else ""
        if wanted not in states:
            hint = nearest(wanted, states)
            raise file.error(parts["name"], f"{name}: there is no joint state {wanted!r}{hint}")
        yield states[wanted], _number(file, parts["interpolate_time"]), _number(file, parts["pause_time"]), item
