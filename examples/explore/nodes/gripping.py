"""A node that proposes grasps of what lies in a heap, for a hand of two fingers, from the points of a cloud alone.

Around points of the cloud, the hand is tried in many directions: nothing may lie where its fingers and its palm will
be, and between the fingers there have to be two surfaces that face them (antipodal grasps; ten Pas et al., "Grasp Pose
Detection in Point Clouds", IJRR 2017, samples them likewise). What no camera has seen counts as free: that is where
one view goes wrong.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

import grip_bt as grip
from grip_bt.base.arrays import Array
from grip_bt.base.failures import NoGraspError
from grip_bt.base.values import Grasp, PointCloud, Pose
from grip_bt.base.values.joints import Span

OWN = 1e3
"""No limit but the hand's own [N m]."""
SAMPLES, YAWS = 100, 8
TILTS = ((0.0, 0.0), (0.4, 0.0), (0.4, np.pi / 2), (0.4, np.pi), (0.4, -np.pi / 2))
"""Of the approach from straight down, and to which side [rad]."""
DEEP = 0.022
"""How far below a point the tips reach [m]."""
GAP = 0.004
"""Of the tips above the floor [m]."""
ROOM = 0.006
"""Between each finger and a thing [m]."""
PAD = 0.009
"""Half of what the fingers are broad [m]."""
FINGER = 0.018
"""How thick a finger is, along the way it closes [m]."""
PALM = (0.105, 0.035)
"""Half of what the hand behind the fingers covers, along the way they close and across it [m]."""
END = 0.006
"""What lies so near to the outermost points between the fingers is what they touch [m]."""
LEAST = 8
"""Fewer points between the fingers are noise."""
FLOOR = 0.010
"""What is lower is the floor [m]."""
REACH = 0.12
"""What is farther from a point can't be touched by a hand around it [m]."""


@dataclass(frozen=True)
class Ways:
    """Directions in which the hand is tried: rows of each matrix are where it closes, across, and approaches."""

    frames: Array

    @classmethod
    def all(cls) -> Ways:
        """Return every turn about every approach."""
        frames = []
        for tilt, side in TILTS:
            approach = np.array([np.sin(tilt) * np.cos(side), np.sin(tilt) * np.sin(side), -np.cos(tilt)])
            for yaw in np.arange(YAWS) * np.pi / YAWS:
                closing = np.array([np.cos(yaw), np.sin(yaw), 0.0])
                closing -= closing @ approach * approach
                closing /= np.linalg.norm(closing)
                frames.append([closing, np.cross(approach, closing), approach])
        return cls(np.array(frames))


@grip.leaf("explore/propose", outputs={"grasps": list[Grasp]}, codes=("no_grasp",))
def propose(
    context: grip.Context,
    cloud: PointCloud,
    *,
    hand: str = "",
    approach: float = 0.10,
    lift: float = 0.15,
    most: int = 40,
) -> list[Grasp]:
    """Propose grasps of what a cloud shows, the best first."""
    span = context.hand(hand).spans()[0]
    found = candidates(np.asarray(cloud.points, float), span.gap, span.depth)
    if not found:
        raise NoGraspError("nowhere do two surfaces that face the fingers have room for them beside them")
    found.sort(key=lambda each: -each[0])
    return [_grasp(span, *each[1:], each[0], approach, lift) for each in found[:most]]


Candidate = tuple[float, Array, Array, float]
"""Quality, the frame of the hand as in `Ways`, the place between the tips in world, and how wide what is there is."""


def candidates(points: Array, gap: float, depth: float) -> list[Candidate]:
    """Return the grasps of what lies on a floor at z = 0, in no order.

    Args:
        points: shape (n, 3), in world [m].
        gap: how wide the hand opens [m].
        depth: how far its fingers reach [m].
    """
    things = points[points[:, 2] > FLOOR]
    if len(things) < LEAST:
        return []
    tree = cKDTree(things)
    normals = normals_of(things, tree)
    rng, frames = np.random.default_rng(0), Ways.all().frames
    found: list[Candidate] = []
    for index in rng.choice(len(things), min(SAMPLES, len(things)), replace=False):
        near = tree.query_ball_point(things[index], REACH)
        found += _around(things[index], things[near], normals[near], frames, gap, depth)
    return found


def normals_of(points: Array, tree: cKDTree, count: int = 14) -> Array:
    """Return the direction of the surface at each point, shape (n, 3), to whichever side."""
    _, near = tree.query(points, k=min(count, len(points)))
    around = points[near] - points[near].mean(axis=1, keepdims=True)
    _, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))
    return np.asarray(vectors[:, :, 0])


def _around(point: Array, things: Array, normals: Array, frames: Array, gap: float, depth: float) -> list[Candidate]:
    """Return the grasps with the hand around a point."""
    found: list[Candidate] = []
    local = np.einsum("fij,nj->fni", frames, things - point)
    deep = np.minimum(DEEP, (point[2] - GAP) / -frames[:, 2, 2])  # of the tips, from the point along the approach
    between = (np.abs(local[:, :, 0]) < gap / 2) & (np.abs(local[:, :, 1]) < PAD)
    between &= (local[:, :, 2] < deep[:, None]) & (local[:, :, 2] > deep[:, None] - depth)
    for k in np.flatnonzero(between.sum(axis=1) >= LEAST):
        inside = local[k, between[k], 0]
        low, high = inside.min(), inside.max()
        width = high - low
        if not 0.005 < width < gap - 2 * ROOM:
            continue
        along = local[k] - [(low + high) / 2, 0.0, 0.0]
        if _touches(along, gap, depth, deep[k]):
            continue
        facing = np.abs(normals[between[k]] @ frames[k, 0])
        ends = [facing[inside < low + END], facing[inside > high - END]]
        level = float(min(end.mean() for end in ends))
        if level < 0.5:
            continue
        held = local[k, between[k]]
        beside = np.abs(np.median(along[np.abs(along[:, :2]).max(axis=1) < 0.05, 1]))  # from the middle of the thing
        quality = level + 0.5 * min(1.0, np.ptp(held[:, 1]) / PAD / 2) - 4 * beside - 0.3 * (1 + frames[k, 2, 2])
        quality += 2 * float(point[2])  # what lies on top is free
        place = point + frames[k].T @ np.array([(low + high) / 2, 0.0, deep[k]])
        found.append((quality, frames[k], place, float(width)))
    return found


def _touches(along: Array, gap: float, depth: float, deep: float) -> bool:
    """Tell whether fingers or palm would be where something is; points are given in the hand's frame."""
    closing, across, down = np.abs(along[:, 0]), np.abs(along[:, 1]), along[:, 2]
    fingers = (closing > gap / 2) & (closing < gap / 2 + FINGER) & (across < PAD + 0.003) & (down < deep + 0.003)
    palm = (closing < PALM[0]) & (across < PALM[1]) & (down < deep - depth)
    return bool(fingers.sum() > 2 or palm.sum() > 2)


def _grasp(span: Span, frame: Array, place: Array, width: float, quality: float, approach: float, lift: float) -> Grasp:
    own = np.stack([span.axis, np.cross(span.inward, span.axis), span.inward], axis=1)
    rotation = frame.T @ own.T
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, place - rotation @ span.middle
    pose = Pose.from_matrix(matrix)
    return Grasp(
        pose,
        pose.moved(-approach * frame[2]),
        pose.moved((0.0, 0.0, lift)),
        pre_posture=span.posture,
        torque_limit=OWN,
        width=width,
        quality=quality,
        provenance="explore/propose",
    )
