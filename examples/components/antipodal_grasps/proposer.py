"""Propose grasps for things on a table, from a point cloud seen from above. Plain numpy and OpenCV.

What stands is taken from the side, what lies from above. The hand's frame: origin on the palm, z out of the palm (the
approach), x along the fingers, y the axis about which the fingers flex. A power grasp of an upright thing has z
horizontal and y vertical; a pinch of a lying one has y along it, and thumb and fingers on either side. Lengths in m,
angles in rad, world frame: z up, the robot's base at the origin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from splitting import parts

Array = NDArray[np.float64]

# Where to look.
PICK_X = (0.36, 0.72)
PICK_Y = (-0.16, 0.40)
TABLE = 0.0
MIN_HEIGHT = 0.03  # points lower above the table are the table
MAX_HEIGHT = 0.35  # points higher above the table are the robot
CELL = 0.008  # grid in which neighbouring points become one thing
MIN_POINTS = 30

# The hand.
YAWS = 24
PALM_GAP = 0.004  # between palm and thing
SHIFT = 0.018  # of the thing along the fingers: beside the root of the thumb, which rises above the palm
PALM_HEIGHT = 0.09  # lowest palm above the table: hand and wrist are that wide
MAX_WIDTH = 0.09  # widest thing that the fingers close around
APPROACH = 0.12
LIFT = 0.20  # higher than the neighbours
FINGERS = 0.13  # length of the open fingers
FOREARM = 0.22  # what follows behind the palm and is as thick as the hand
HAND_RADIUS = 0.05

# A pinch from above, in the plane of x and z. The thumb is longer than the curled fingers, so the hand leans until
# their tips are level; between them, when they are half closed, is MIDDLE, found with the hand's kinematics.
LEAN = 0.45
MIDDLE = np.array([0.035, 0.0, 0.09])
REACH_DOWN = 0.118  # how far below the palm, along the vertical, the leaning fingers sweep when they close
FOOTPRINT = (0.10, 0.07)  # half of what the open hand covers seen from above, across the thing and along it
LOWEST = 0.035  # what is lower lies too deep between the finger tips
ALONG = (0.0, 0.025, -0.025)  # where along the thing, from its middle

# What a good grasp is.
ROUND = 0.89  # a square fills its bounding rectangle, a disc 0.785 of it
OUTWARD, FREE, ALIGNED, NEAR = 1.0, 6.0, 1.0, 0.6
STANDING_FIRST = 1.0


@dataclass(frozen=True)
class Frame:
    """A pose: position (3,) and quaternion (4,), ordered x y z w as in ROS messages."""

    position: Array
    quaternion: Array


@dataclass(frozen=True)
class Candidate:
    """One way to take a thing; the frames are the hand's."""

    pose: Frame
    pre_grasp: Frame
    post_grasp: Frame
    width: float
    quality: float


@dataclass(frozen=True)
class Thing:
    """A prism or cylinder, standing or lying.

    Attributes:
        outline: its corners, seen from above, shape (k, 2).
        centre: of the outline, shape (2,).
        angle: of one of its faces; 0 for a round thing. Of a lying one, the direction in which it is longest.
        top: height above the table.
        is_round: whether it is an upright cylinder.
        lies: whether it is too low to be taken from the side.
    """

    outline: Array
    centre: Array
    angle: float
    top: float
    is_round: bool
    lies: bool = False

    def half_width(self, direction: Array) -> float:
        """Return half its extent along a horizontal unit vector."""
        along = self.outline @ direction
        return float(along.max() - along.min()) / 2


def propose(points: Array) -> list[Candidate]:
    """Return grasps of everything that stands or lies in the pick region, the best first.

    Args:
        points: shape (n, 3), world frame; what isn't finite is ignored.
    """
    groups = (part for cluster in clusters(points) for part in parts(cluster, TABLE + PALM_HEIGHT, MIN_POINTS))
    things = [thing for group in groups if (thing := fit(group)) is not None]
    found = []
    for i, thing in enumerate(things):
        ways = pinches if thing.lies else grasps
        found += ways(thing, things[:i] + things[i + 1 :])
    return sorted(found, key=lambda candidate: -candidate.quality)


def clusters(points: Array) -> list[Array]:
    """Return the points of each thing: what touches seen from above, in the pick region and above the table."""
    points = np.asarray(points, dtype=float).reshape(-1, 3)
    x, y, z = points.T
    with np.errstate(invalid="ignore"):
        inside = (x > PICK_X[0]) & (x < PICK_X[1]) & (y > PICK_Y[0]) & (y < PICK_Y[1])
        inside &= (z > TABLE + MIN_HEIGHT) & (z < TABLE + MAX_HEIGHT)
    points = points[inside]
    cells = np.floor((points[:, :2] - [PICK_X[0], PICK_Y[0]]) / CELL).astype(int)
    shape = np.ceil([(PICK_X[1] - PICK_X[0]) / CELL, (PICK_Y[1] - PICK_Y[0]) / CELL]).astype(int) + 1
    grid = np.zeros(shape, np.uint8)
    grid[cells[:, 0], cells[:, 1]] = 1
    count, labels = cv2.connectedComponents(grid, connectivity=8)
    label = labels[cells[:, 0], cells[:, 1]]
    groups = (points[label == k] for k in range(1, count))
    return [group for group in groups if len(group) >= MIN_POINTS]


def fit(points: Array) -> Thing | None:
    """Fit a cylinder or prism; None where the cluster is too low or too wide for the hand.

    A camera above sees the whole top and some of the sides, so the foot is taken from the highest points only. How
    much of its bounding rectangle (`cv2.minAreaRect`) the top's hull fills tells a disc from a square.
    """
    top = float(np.percentile(points[:, 2], 99))
    if top - TABLE < PALM_HEIGHT:
        return fit_lying(points, top - TABLE)
    highest = points[points[:, 2] > top - 0.012]
    hull = cv2.convexHull(highest[:, :2].astype(np.float32))
    (x, y), (width, depth), degrees = cv2.minAreaRect(hull)
    if min(width, depth) > MAX_WIDTH or min(width, depth) < 0.01:
        return None
    is_round = cv2.contourArea(hull) < ROUND * width * depth and max(width, depth) < 1.2 * min(width, depth)
    if is_round:
        (x, y), radius = cv2.minEnclosingCircle(hull)
        turn = np.linspace(0, 2 * np.pi, 48, endpoint=False)
        outline = np.array([x, y]) + radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        return Thing(outline, np.array([x, y]), 0.0, top - TABLE, True)
    corners = cv2.boxPoints(((x, y), (width, depth), degrees)).astype(float)
    return Thing(corners, np.array([x, y]), float(np.radians(degrees)), top - TABLE, False)


def fit_lying(points: Array, top: float) -> Thing | None:
    """Fit what lies: the rectangle around all that is seen of it; None where that is too low or too wide."""
    (x, y), (width, depth), degrees = cv2.minAreaRect(points[:, :2].astype(np.float32))
    if top < LOWEST or not 0.01 < min(width, depth) <= MAX_WIDTH:
        return None
    corners = cv2.boxPoints(((x, y), (width, depth), degrees)).astype(float)
    angle = float(np.radians(degrees)) + (np.pi / 2 if depth > width else 0.0)
    return Thing(corners, np.array([x, y]), angle, top, is_round=False, lies=True)


def pinches(thing: Thing, others: Sequence[Thing]) -> list[Candidate]:
    """Return grasps of a lying thing from above, with thumb and fingers across it, that keep clear of the others."""
    reach = float(np.linalg.norm(thing.centre))
    longest, shortest = (thing.half_width(unit(thing.angle + k * np.pi / 2)) for k in (0, 1))
    turns = (0.0, np.pi / 2) if 2 * longest <= MAX_WIDTH else (0.0,)
    found = []
    for turn in turns:
        axis = unit(thing.angle + turn)
        across = np.array([-axis[1], axis[0]])
        for side in (1.0, -1.0):
            rotation = pinch_rotation(side * across)
            # Closing fingers sweep to REACH_DOWN below the palm, which is to be above the table: a low thing is held
            # nearer to their tips.
            palm_height = max(-float(rotation[2] @ MIDDLE) + thing.top / 2, REACH_DOWN)
            for along in ALONG:
                if abs(along) > max(0.0, longest - 0.04):
                    continue
                spot = np.array([*(thing.centre + along * axis), TABLE + thing.top / 2])
                palm = spot - rotation @ MIDDLE
                palm[2] = TABLE + palm_height
                free = room_above(spot[:2], axis, across, others)
                if free < 0:
                    continue
                quality = FREE * min(free, 0.06) - NEAR * reach - 10 * abs(along) - STANDING_FIRST
                found.append(candidate(palm, rotation, rotation[:, 2], 2 * shortest, quality))
    return found


def pinch_rotation(across: Array) -> Array:
    """Return the hand's rotation matrix above a thing: x leans down along the horizontal unit vector `across`."""
    ahead, up = np.array([*across, 0.0]), np.array([0.0, 0.0, 1.0])
    z = -np.cos(LEAN) * up - np.sin(LEAN) * ahead
    x = np.cos(LEAN) * ahead - np.sin(LEAN) * up
    return np.stack([x, np.cross(z, x), z], axis=1)


def room_above(spot: Array, axis: Array, across: Array, others: Sequence[Thing]) -> float:
    """Return how far the open hand stays from other things, seen from above; negative when they touch [m]."""
    wide, long = np.meshgrid(np.linspace(-1, 1, 9) * FOOTPRINT[0], np.linspace(-1, 1, 7) * FOOTPRINT[1])
    samples = spot + wide.reshape(-1, 1) * across + long.reshape(-1, 1) * axis
    free = 1.0
    for other in others:
        radius = float(np.linalg.norm(other.outline - other.centre, axis=1).max())
        free = min(free, float(np.linalg.norm(samples - other.centre, axis=1).min()) - radius)
    return free


def grasps(thing: Thing, others: Sequence[Thing]) -> list[Candidate]:
    """Return the side grasps of one thing that keep the hand clear of the others."""
    height = TABLE + max(PALM_HEIGHT, 0.55 * thing.top)
    narrowest = min(thing.half_width(unit(thing.angle + k * np.pi / 2)) for k in (0, 1))
    reach = float(np.linalg.norm(thing.centre))
    found = []
    for k in range(YAWS):
        approach = unit(thing.angle + 2 * np.pi * k / YAWS)
        across = thing.half_width(np.array([-approach[1], approach[0]]))
        if 2 * across > MAX_WIDTH:
            continue
        depth = thing.half_width(approach)
        for flip in (1.0, -1.0):
            rotation = side_rotation(approach, flip)
            palm = np.array([*(thing.centre - (depth + PALM_GAP) * approach), height]) - SHIFT * rotation[:, 0]
            free = clearance(palm[:2], approach, rotation[:2, 0], others)
            if free < 0:
                continue
            quality = (
                OUTWARD * float(approach @ thing.centre) / reach
                + FREE * min(free, 0.06)
                - ALIGNED * (depth - narrowest) / narrowest
                - NEAR * reach
            )
            found.append(candidate(palm, rotation, approach, 2 * across, quality))
    return found


def candidate(palm: Array, rotation: Array, approach: Array, width: float, quality: float) -> Candidate:
    """Return a grasp with its straight approach, along a unit vector of 2 or 3 numbers, and its straight lift."""
    q = quaternion(rotation)
    back = -APPROACH * np.array([*approach, 0.0])[:3]
    up = np.array([0.0, 0.0, LIFT])
    return Candidate(Frame(palm, q), Frame(palm + back, q), Frame(palm + up, q), width, quality)


def clearance(palm: Array, approach: Array, fingers: Array, others: Sequence[Thing]) -> float:
    """Return how far hand and forearm stay from other things, seen from above; negative when they touch [m].

    The hand counts as thick line segments: from the palm back along the approach, and along the open fingers, at the
    grasp and where the approach begins.
    """
    lines = [
        palm - np.linspace(0, APPROACH + FOREARM, 18)[:, None] * approach,
        palm + np.linspace(0, FINGERS, 8)[:, None] * fingers,
        palm - APPROACH * approach + np.linspace(0, FINGERS, 8)[:, None] * fingers,
    ]
    thickness = np.repeat([HAND_RADIUS, 0.015, 0.015], [len(line) for line in lines])
    samples = np.concatenate(lines)
    free = 1.0
    for other in others:
        radius = float(np.linalg.norm(other.outline - other.centre, axis=1).max())
        away = np.linalg.norm(samples - other.centre, axis=1) - radius - thickness
        free = min(free, float(away.min()))
    return free


def side_rotation(approach: Array, flip: float) -> Array:
    """Return the hand's rotation matrix: z along the horizontal approach, y up (flip = 1) or down (flip = -1)."""
    z, y = np.array([*approach, 0.0]), np.array([0.0, 0.0, flip])
    return np.stack([np.cross(y, z), y, z], axis=1)


def unit(yaw: float) -> Array:
    """Return the horizontal unit vector at an angle from x, shape (2,)."""
    return np.array([np.cos(yaw), np.sin(yaw)])


def quaternion(rotation: Array) -> Array:
    """Return the unit quaternion, x y z w, of a rotation matrix: the eigenvector of Bar-Itzhack's method (2000)."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rotation
    k = np.array(
        [
            [xx - yy - zz, yx + xy, zx + xz, zy - yz],
            [yx + xy, yy - xx - zz, zy + yz, xz - zx],
            [zx + xz, zy + yz, zz - xx - yy, yx - xy],
            [zy - yz, xz - zx, yx - xy, xx + yy + zz],
        ]
    )
    q: Array = np.linalg.eigh(k)[1][:, -1]
    return q if q[3] >= 0 else -q
