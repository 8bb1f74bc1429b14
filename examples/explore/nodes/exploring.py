"""Nodes of `tasks/explore.yaml` that look around: where to look from, and what of each view is kept."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import grip_bt as grip
from grip_bt.base.arrays import Array
from grip_bt.base.failures import SensorError
from grip_bt.base.values import PointCloud, Pose


@grip.leaf("explore/spiral", outputs={"way": list[Pose]})
def spiral(
    context: grip.Context,
    *,
    arm: str = "",
    sensor: str = "wrist",
    centre: list[float],
    views: int = 8,
    turns: float = 1.5,
    distance: float = 0.42,
    steepest: float = 1.45,
    flattest: float = 0.85,
) -> list[Pose]:
    """Return where the hand has to be for a camera that it carries to look at a point [m] from a spiral down around it.

    The camera stays at a distance [m] and sinks from the steepest to the flattest angle above the horizon [rad].
    """
    on_hand = context.arm(arm).grasp_pose().inverse() @ context.camera(sensor).info().pose
    return [pose @ on_hand.inverse() for pose in looking(np.array(centre), views, turns, distance, steepest, flattest)]


def looking(centre: Array, views: int, turns: float, distance: float, steepest: float, flattest: float) -> list[Pose]:
    """Return the cameras' optical frames along the spiral; up in their images is as nearly world +x as can be."""
    share = np.linspace(0, 1, views)
    angles, heights = 2 * np.pi * turns * share, steepest + (flattest - steepest) * share
    found = []
    for angle, height in zip(angles, heights, strict=True):
        outward = np.array([np.cos(height) * np.cos(angle), np.cos(height) * np.sin(angle), np.sin(height)])
        down = -(np.array([1.0, 0.0, 0.0]) - outward[0] * outward)
        y = down / np.linalg.norm(down)
        matrix = np.eye(4)
        matrix[:3] = np.column_stack([np.cross(y, -outward), y, -outward, centre + distance * outward])
        found.append(Pose.from_matrix(matrix))
    return found


@grip.leaf("explore/keep", outputs={"clouds": list[PointCloud]}, codes=("no_data",))
def keep(
    cloud: PointCloud,
    clouds: list[PointCloud],
    *,
    region: list[float] = [0.33, 0.67, -0.20, 0.20, -0.03, 0.25],  # noqa: B006 - read as a literal
    cell: float = 0.004,
) -> list[PointCloud]:
    """Add what a cloud shows of a region (x, y and z from and to, in world [m]) to a list, a point a cell [m]."""
    low, high = np.reshape(region, (3, 2)).T
    points = np.asarray(cloud.points, float)
    points = thinned(points[((points > low) & (points < high)).all(axis=1)], cell)
    if not len(points):
        raise SensorError("the cloud shows nothing of the region")
    return [*clouds, PointCloud(points.astype(np.float32), None, cloud.frame, cloud.time)]


@grip.leaf("explore/join", outputs={"cloud": PointCloud})
def join(clouds: list[PointCloud], *, cell: float = 0.004) -> PointCloud:
    """Put clouds together as they are, a point a cell [m]."""
    points = np.concatenate([np.asarray(cloud.points, float) for cloud in clouds])
    return PointCloud(thinned(points, cell).astype(np.float32), None, clouds[0].frame, clouds[-1].time)


def thinned(points: Array, cell: float) -> Array:
    """Return the mean of the points in each cell [m], shape (m, 3)."""
    keys = np.floor(points / cell).astype(np.int64)
    _, which, count = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    sums: Sequence[Array] = [np.bincount(which.reshape(-1), points[:, axis]) for axis in range(3)]
    return np.stack(sums, axis=1) / count[:, None]
