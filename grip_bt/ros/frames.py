"""Where frames are in each other: from fixed transforms, and from the stamped ones of the last seconds.

The tree knows only what never moves (links of the robot's description, the project's sensors); what moves is asked of
TF (`grip_bt.ros.transforms`) or of the robot's model. Between two stamped transforms, positions are interpolated
linearly, orientations along the shortest turn (slerp, Shoemake 1985). Nothing is extrapolated.
"""

from __future__ import annotations

import bisect
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from operator import itemgetter

import numpy as np

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import ExpectedError
from grip_bt.base.values import Grasp, PointCloud, Pose
from grip_bt.commanders.description.tree import Tree
from grip_bt.task.catalog.ros_config import CameraTopics, SensorConfig

ROOT = "world"


class FrameError(ExpectedError):
    """A frame isn't there, or isn't connected with another."""

    code = "no_frame"


class FrameTree:
    """Frames that don't move.

    Args:
        poses: frame -> its pose in its parent (`pose.frame`). A frame that is only named as a parent is a root.
    """

    def __init__(self, poses: Mapping[str, Pose] | None = None):
        self._poses = dict(poses or {})

    @classmethod
    def of_urdf(cls, urdf: str, root: str = ROOT) -> FrameTree:
        """Return the links that fixed joints connect; the description's own root link is where `root` is."""
        tree = Tree.of(urdf)
        fixed = {joint.child: joint.origin for joint in tree.joints.values() if joint.type == "fixed"}
        return cls(fixed | ({} if tree.root == root else {tree.root: Pose(frame=root)}))

    def with_poses(self, poses: Mapping[str, Pose]) -> FrameTree:
        return FrameTree({**self._poses, **poses})

    @property
    def poses(self) -> dict[str, Pose]:
        return dict(self._poses)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(sorted(set(self._poses) | {p.frame for p in self._poses.values()}))

    def lookup(self, target: str, source: str) -> Pose:
        """Return the pose of `source` in `target`.

        Raises:
            FrameError: a frame isn't there, or nothing fixed connects the two.
        """
        if target == source:
            return Pose(frame=target)
        for name in (target, source):
            if name not in self.names:
                raise FrameError(str(UnknownNameError("frame", name, self.names)), frame=name)
        top_s, in_top_s = self._to_top(source)
        top_t, in_top_t = self._to_top(target)
        if top_s != top_t:
            reason = f"{source!r} isn't connected with {target!r} by fixed frames ({source} hangs on {top_s}, "
            raise FrameError(f"{reason}{target} on {top_t})", frame=source)
        return Pose.from_matrix((in_top_t.inverse() @ in_top_s).matrix(), target)

    def _to_top(self, name: str) -> tuple[str, Pose]:
        pose, seen = Pose(frame=name), set()
        while name in self._poses and name not in seen:
            seen.add(name)
            pose, name = self._poses[name] @ pose, self._poses[name].frame
        return name, pose


def mounted_frames(sensors: Mapping[str, SensorConfig | CameraTopics]) -> tuple[dict[str, Pose], dict[str, str]]:
    """Return the frames of sensors in what they are mounted on, and, by sensor, why some of them can't be used."""
    poses, broken = {}, {}
    for name, config in sensors.items():
        if config.mount is not None:
            try:
                mount = config.mount
                poses[mount.frame] = Pose(mount.position, mount.quaternion, mount.on)
            except ValueError as error:
                broken[name] = f"mount: {error}"
    return poses, broken


def transformed(value: object, pose: Pose) -> object:
    """Return a value that was given in a frame, as seen in the frame in which that frame has the pose `pose`.

    Raises:
        TypeError: it has no frame that could be changed.
    """
    if isinstance(value, Pose):
        return pose @ value
    if isinstance(value, PointCloud):
        return replace(value, points=pose.apply(value.points).astype(np.float32), frame=pose.frame)
    if isinstance(value, Grasp):
        moved = {n: pose @ getattr(value, n) for n in ("pose", "pre_grasp", "post_grasp")}
        return replace(value, **moved)
    if isinstance(value, (list, tuple)):
        return [transformed(item, pose) for item in value]
    raise TypeError(f"a {type(value).__name__} can't be transformed into another frame")


def frame_of(value: object) -> str | None:
    """Return the frame that a value is given in; None when it has none, or is an empty list."""
    if isinstance(value, (list, tuple)):
        return frame_of(value[0]) if value else None
    if isinstance(value, Grasp):
        return value.pose.frame
    return getattr(value, "frame", None)


KEPT = 10.0
"""How long transforms are kept [s], by their stamps."""


@dataclass
class _Track:
    poses: list[tuple[float, Pose]] = field(default_factory=list)
    """(stamp, pose), by their stamps."""
    heard: float = float("-inf")


class FrameHistory:
    """The transforms of frames that move. Not safe for several threads at once; whoever keeps it holds a lock."""

    def __init__(self) -> None:
        self._tracks: dict[str, _Track] = {}

    def add(self, child: str, pose: Pose, stamp: float, heard: float) -> None:
        """Take in a transform.

        Args:
            pose: where it is in its parent (`pose.frame`).
            stamp: when it was there [s]. A stamp far back means that time began anew: what was before is forgotten.
            heard: when that was heard, on this process's steady clock [s].
        """
        track = self._tracks.setdefault(child, _Track())
        track.heard = heard
        if track.poses and (stamp < track.poses[-1][0] - KEPT or track.poses[-1][1].frame != pose.frame):
            track.poses.clear()
        place = bisect.bisect_left(track.poses, stamp, key=itemgetter(0))
        same = track.poses[place : place + 1] and track.poses[place][0] == stamp
        track.poses[place : place + bool(same)] = [(stamp, pose)]
        del track.poses[: bisect.bisect_left(track.poses, track.poses[-1][0] - KEPT, key=itemgetter(0))]

    def latest(self, heard_since: float) -> dict[str, Pose]:
        """Return the last transform of each frame that was heard of since then."""
        return {child: track.poses[-1][1] for child, track in self._tracks.items() if track.heard > heard_since}

    def at(self, time: float) -> dict[str, Pose]:
        """Return where each frame was at a time [s]; frames of which that isn't known are left out."""
        found = ((child, _at(track, time)) for child, track in self._tracks.items())
        return {child: pose for child, pose in found if pose is not None}

    def spans(self) -> dict[str, tuple[float, float]]:
        """Return from when to when each frame is known [s]."""
        return {child: (track.poses[0][0], track.poses[-1][0]) for child, track in self._tracks.items()}


def _at(track: _Track, time: float) -> Pose | None:
    if not track.poses[0][0] <= time <= track.poses[-1][0]:
        return None
    after = bisect.bisect_left(track.poses, time, key=itemgetter(0))
    if track.poses[after][0] == time:
        return track.poses[after][1]
    (begin, one), (end, other) = track.poses[after - 1 : after + 1]
    return between(one, other, (time - begin) / (end - begin))


def between(one: Pose, other: Pose, part: float) -> Pose:
    """Return the pose that lies at `part`, in [0, 1], of the way between two in the same frame."""
    position = (1 - part) * one.position + part * other.position
    far = other.quaternion if one.quaternion @ other.quaternion >= 0 else -other.quaternion  # the shorter way
    angle = 2 * np.arctan2(np.linalg.norm(far - one.quaternion), np.linalg.norm(far + one.quaternion))
    weight, far_weight = (share * np.sinc(share * angle / np.pi) for share in (1 - part, part))
    return Pose(position, weight * one.quaternion + far_weight * far, one.frame)
