"""Where moving frames were: the stamped transforms of the last seconds, and what lies between two of them.

Positions are interpolated linearly, orientations along the shortest turn (slerp, Shoemake 1985). Nothing is
extrapolated: where a frame was before it was first heard of, or will be, isn't known.
"""

from __future__ import annotations

import bisect
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from grip_bt.base.values import Pose

KEPT = 10.0
"""How long transforms are kept [s], by their stamps."""


@dataclass
class _Track:
    """The transforms of one frame, by their stamps."""

    stamps: deque[float] = field(default_factory=deque)
    poses: deque[Pose] = field(default_factory=deque)
    heard: float = float("-inf")


class FrameHistory:
    """The transforms of frames that move. Not safe for several threads at once; whoever keeps it holds a lock."""

    def __init__(self) -> None:
        self._tracks: dict[str, _Track] = {}

    def add(self, child: str, pose: Pose, stamp: float, heard: float) -> None:
        """Take in a transform.

        Args:
            child: the frame.
            pose: where it is in its parent (`pose.frame`).
            stamp: when it was there [s]. A stamp far back means that time began anew: what was before is forgotten.
            heard: when that was heard, on this process's steady clock [s].
        """
        track = self._tracks.setdefault(child, _Track())
        track.heard = heard
        newest = track.stamps[-1] if track.stamps else stamp
        if stamp < newest - KEPT or (track.poses and track.poses[-1].frame != pose.frame):
            track.stamps.clear()
            track.poses.clear()
        place = bisect.bisect_left(track.stamps, stamp)
        if place < len(track.stamps) and track.stamps[place] == stamp:
            track.poses[place] = pose
        else:
            track.stamps.insert(place, stamp)
            track.poses.insert(place, pose)
        while track.stamps[-1] - track.stamps[0] > KEPT:
            track.stamps.popleft()
            track.poses.popleft()

    def latest(self, heard_since: float) -> dict[str, Pose]:
        """Return the last transform of each frame that was heard of since then."""
        return {child: track.poses[-1] for child, track in self._tracks.items() if track.heard > heard_since}

    def at(self, time: float) -> dict[str, Pose]:
        """Return where each frame was at a time [s]; frames of which that isn't known are left out."""
        found = {}
        for child, track in self._tracks.items():
            pose = _at(track, time)
            if pose is not None:
                found[child] = pose
        return found

    def spans(self) -> dict[str, tuple[float, float]]:
        """Return from when to when each frame is known [s]."""
        return {child: (track.stamps[0], track.stamps[-1]) for child, track in self._tracks.items()}


def _at(track: _Track, time: float) -> Pose | None:
    if not track.stamps[0] <= time <= track.stamps[-1]:
        return None
    after = bisect.bisect_left(track.stamps, time)
    if track.stamps[after] == time:
        return track.poses[after]
    begin, end = track.stamps[after - 1], track.stamps[after]
    return between(track.poses[after - 1], track.poses[after], (time - begin) / (end - begin))


def between(one: Pose, other: Pose, part: float) -> Pose:
    """Return the pose that lies at `part`, in [0, 1], of the way between two in the same frame."""
    position = (1 - part) * one.position + part * other.position
    q, r = one.quaternion, other.quaternion
    cosine = float(q @ r)
    if cosine < 0:  # both signs are the same orientation; this one turns less
        r, cosine = -r, -cosine
    angle = np.arccos(min(cosine, 1.0))
    if angle < 1e-6:  # the limit of what follows
        return Pose(position, (1 - part) * q + part * r, one.frame)
    mixed = (np.sin((1 - part) * angle) * q + np.sin(part * angle) * r) / np.sin(angle)
    return Pose(position, mixed, one.frame)
