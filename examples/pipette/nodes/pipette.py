"""Nodes for `tasks/pipette.yaml`: what stands on the bench, ways to grasp it, and where a held pipette's tip is.

The hand's grasp frame is its palm, as the launch file's robot has it: x runs across the fingers to the thumb's side, z
along the fingers, and -y leaves the palm. It grasps what stands upright with x up, so that the thumb is above.
"""

from __future__ import annotations

import numpy as np

import grip_bt as grip
from grip_bt.base.failures import NoGraspError
from grip_bt.base.values import Grasp, PointCloud, Pose
from grip_bt.base.values.pose import quaternion_of

AXIS = 0.095
"""How far along the palm what is grasped crosses it [m]."""
TIP = 0.003
"""Radius of the pipette's tip [m]: a camera sees only the side that faces it."""


@grip.leaf("pipette/find", outputs={"top": Pose}, codes=("no_grasp",))
def find(cloud: PointCloud, *, x: list[float], y: list[float], above: float, below: float = 1.0) -> Pose:
    """Return the middle of the top of the upright thing in a part of the table, x from - to and y from - to [m].

    Args:
        above: lower points are of something else, or of its lower parts [m].
        below: higher ones are of the arm [m].
    """
    points = cloud.points
    low, high = np.array([x[0], y[0], above]), np.array([x[1], y[1], below])
    points = points[np.all((points > low) & (points < high), axis=1)]
    if len(points) < 10:
        raise NoGraspError(f"nothing higher than {above:g} m is seen between x {x} and y {y} [m]")
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    return Pose((middle[0], middle[1], float(np.percentile(points[:, 2], 95))))


@grip.leaf("pipette/ways", outputs={"grasps": list[Grasp]}, quick=True)
def ways(top: Pose, *, below_top: float, away: float, back: float = 0.12, lift: float = 0.2) -> list[Grasp]:
    """Say how the palm may stand at an upright thing, the thumb above; it comes from the side.

    Args:
        below_top: height of the palm's middle below the thing's top [m].
        away: distance of the thing's axis from the palm's frame [m].
        back: where the straight way to it begins [m].
        lift: where the straight way up ends [m].
    """
    grasps = []
    for yaw in (0.0, 0.2, -0.2, 0.4, -0.4):
        turned = Pose((0.0, 0.0, 0.0), quaternion_of(0.0, 0.0, yaw)).rotation()
        place = np.eye(4)
        place[:3, :3] = turned @ np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
        place[:3, 3] = top.position - place[:3, :3] @ [below_top, -away, AXIS]
        pose = Pose.from_matrix(place)
        begin = pose.moved(tuple(-back * (turned @ [0.0, 1.0, 0.0])))
        grasps.append(Grasp(pose, begin, pose.moved((0.0, 0.0, lift)), quality=-abs(yaw)))
    return grasps


@grip.leaf("pipette/approach", outputs={"above": Pose, "before": Pose, "at": Pose}, quick=True)
def approach(grasp: Grasp, *, higher: float = 0.25) -> dict[str, Pose]:
    """Return where a hand comes by to a grasp that touches nothing before: high above [m], beside it, there."""
    return {"above": grasp.pre_grasp.moved((0.0, 0.0, higher)), "before": grasp.pre_grasp, "at": grasp.pose}


@grip.leaf("pipette/tip", outputs={"tip": Pose}, codes=("no_grasp",))
def tip(context: grip.Context, cloud: PointCloud, *, arm: str, sensor: str, below: list[float]) -> Pose:
    """Return where the tip of the pipette in the hand is, in the palm's frame, as a camera at the side sees it.

    Args:
        below: where it may be below the palm's middle, from - to [m].
    """
    palm = context.arm(arm).grasp_pose()
    low, high = palm.position[2] - below[1], palm.position[2] - below[0]
    axis = palm.apply([(0.0, -0.035, AXIS)])[0]
    points = cloud.points
    near = np.linalg.norm(points[:, :2] - axis[:2], axis=1) < 0.08
    points = points[near & (points[:, 2] > low) & (points[:, 2] < high)]
    if len(points) < 10:
        raise NoGraspError("the pipette's tip isn't seen below the hand")
    lowest = float(points[:, 2].min())
    end = points[points[:, 2] < lowest + 0.02].mean(axis=0)
    away = end[:2] - context.camera(sensor).info().pose.position[:2]
    end[:2] += TIP * away / np.linalg.norm(away)
    end[2] = lowest
    return Pose(palm.inverse().apply([end])[0])


@grip.leaf("pipette/over", outputs={"above": Pose, "inside": Pose}, quick=True)
def over(
    context: grip.Context, tip: Pose, place: Pose, *, arm: str, high: float, deep: float, lean: float = 0.0
) -> dict[str, Pose]:
    """Return where the palm has to be for the tip to be above a place, and in it: at two heights of the tip [m].

    Args:
        lean: how far the tip will be nearer to the wrist when the thumb has pressed half of the way [m].
    """
    palm, there = context.arm(arm).grasp_pose(), place.position.copy()
    offset = palm.rotation() @ (tip.position - [0.0, 0.0, lean])
    poses = []
    for height in (high, deep):
        there[2] = height
        poses.append(Pose(there - offset, palm.quaternion))
    return {"above": poses[0], "inside": poses[1]}
