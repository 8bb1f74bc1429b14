"""What lies between a hand's fingers, measured on its collision shapes: how wide, where, and how deep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import coal
import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array
from grip_bt.base.values import JointState
from grip_bt.base.values.joints import Span

from .model import RobotModel, link_of
from .outline import corners

_OPPOSED = 0.02
"""Fingers whose tips are so much further from the thumb's than the nearest don't oppose it [m]."""
_PROBE, _SLACK, _STEP, _DEEPEST = 0.012, 0.005, 0.004, 0.12
"""A bar is pushed in between the fingers: its thickness, its distance from each tip, its steps, and its way [m]."""
_Placed = tuple[coal.CollisionGeometry, pin.SE3]


def spans_of(model: RobotModel, group: str, frame: str, postures: Sequence[JointState]) -> list[Span]:
    """Return what is between a hand's fingers in some postures, seen from a grasp frame.

    The last of its fingers is the thumb, or one of a gripper's two.

    Raises:
        ValueError: it has less than two fingers.
    """
    hand = frozenset(model.description.hands[group])
    *fingers, thumb = [each[-1] for each in model.description.finger_links.values() if each[-1] in hand] or ("",)
    if not fingers:
        raise ValueError(f"hand {group!r} of {model.description.name} has less than two fingers, none to grasp between")
    data, shapes = model.model.createData(), model.geometry.geometryObjects
    palm_joint = model.model.frames[model.model.getFrameId(frame)].parentJoint
    found = []
    for posture in postures:
        pin.framesForwardKinematics(model.model, data, model.configuration(posture))
        palm = data.oMf[model.model.getFrameId(frame)].inverse()
        placed: dict[str, list[_Placed]] = {}
        points = []
        for shape in shapes:
            link = link_of(model.model, shape)
            if link in hand or shape.parentJoint == palm_joint:  # what the palm is fixed to is as much in the way
                body = palm * data.oMi[shape.parentJoint]
                placed.setdefault(link, []).append((shape.geometry, body * shape.placement))
                points.append(corners(shape) @ body.rotation.T + body.translation)
        gap, middle, axis = _between(placed, fingers, thumb)
        span = Span(posture, gap, middle, axis, 0.0, np.concatenate(points))
        found.append(replace(span, depth=_depth(span, placed)))
    return found


def _between(placed: Mapping[str, Sequence[_Placed]], fingers: Sequence[str], thumb: str) -> tuple[float, Array, Array]:
    """Return the gap, its middle, and the direction from the thumb to the fingers that oppose it."""
    nearest = []
    for finger in fingers:
        each = (_nearest(one, other) for one in placed[thumb] for other in placed[finger])
        nearest.append(min(each, key=lambda found: found[0]))
    gap = min(found[0] for found in nearest)
    opposed = [found for found in nearest if found[0] < gap + _OPPOSED]
    near = np.mean([found[1] for found in opposed], axis=0)
    far = np.mean([found[2] for found in opposed], axis=0)
    away = (far - near) * (1.0 if gap >= 0 else -1.0)
    return gap, (near + far) / 2, away / max(float(np.linalg.norm(away)), 1e-9)


def _nearest(one: _Placed, other: _Placed) -> tuple[float, Array, Array]:
    result = coal.DistanceResult()
    distance = coal.distance(*one, *other, coal.DistanceRequest(), result)
    return float(distance), np.array(result.getNearestPoint1()), np.array(result.getNearestPoint2())


def _depth(span: Span, placed: Mapping[str, Sequence[_Placed]]) -> float:
    bar = coal.Box(max(span.gap - 2 * _SLACK, _PROBE), _PROBE, _PROBE)
    turned = np.stack([span.axis, np.cross(span.inward, span.axis), span.inward], axis=1)
    around = [each for shapes in placed.values() for each in shapes]
    for deep in np.arange(_STEP, _DEEPEST, _STEP):
        there = pin.SE3(turned, span.middle - deep * span.inward)
        if any(_nearest((bar, there), each)[0] < 0 for each in around):
            return float(deep - _STEP + _PROBE / 2)
    return _DEEPEST
