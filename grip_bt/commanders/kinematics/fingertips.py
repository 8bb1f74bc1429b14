"""Fingers: joints that bring their tips to targets, and what lies between them, measured on their collision shapes."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from grip_bt.base.arrays import Array
from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import NoIkError
from grip_bt.base.values import JointState
from grip_bt.base.values.joints import Span

from .model import GRASP_FRAME, RobotModel, link_of
from .outline import corners

TOLERANCE = 1e-3
"""Largest distance of a fingertip from its target [m]."""
_FINISHED = 1e-5
_STEPS = 60
_RESTARTS = 12
_DAMPING = 1e-5
_MAX_STEP = 0.4


def fingertip_posture(
    model: RobotModel,
    targets: Mapping[str, Array],
    seed: JointState | None = None,
    group: str = "hand",
    frame: str = GRASP_FRAME,
) -> JointState:
    """Return positions of a hand's joints that bring its fingertips, or other links, to their targets.

    Joints that move none of these fingers stay where `seed` has them.

    Args:
        targets: finger or link -> wanted position of its tip or origin in `frame`, shape (3,) [m].
        seed: posture to begin at, and to stay near; the hand's `open` one when it isn't given.
        group: the hand's group of joints.
        frame: a grasp frame, or a link that the hand's joints don't move and that is fixed to its palm.

    Raises:
        UnknownNameError: there is no such finger, link or frame.
        NoIkError: a tip stays further than 1 mm from its target; `data['distances']` tells how far, by finger.
    """
    tips, rng = _Tips(model, tuple(targets), group, frame), np.random.default_rng(0)
    wanted = np.array([targets[name] for name in tips.fingers], dtype=float).reshape(len(tips.fingers), 3)
    joints = model.description.group(group)
    columns = np.array([model.model.joints[model.model.getJointId(name)].idx_q for name in joints])
    lower, upper = model.model.lowerPositionLimit[columns], model.model.upperPositionLimit[columns]
    first = model.configuration(seed or model.description.named_state(group, "open"))
    best, shortest = first, np.inf
    for start in (first[columns], *(rng.uniform(lower, upper) for _ in range(_RESTARTS))):
        q = first.copy()
        q[columns] = start
        for _ in range(_STEPS):
            error = (wanted - tips.places(q)).ravel()
            if np.abs(error).max() < _FINISHED:
                break
            jacobian = tips.jacobian(q, columns)
            step = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + _DAMPING * np.eye(len(error)), error)
            # Joint by joint: a finger that is far from its target must not slow down the others.
            q[columns] = np.clip(q[columns] + np.clip(step, -_MAX_STEP, _MAX_STEP), lower, upper)
        longest = float(np.linalg.norm(tips.places(q) - wanted, axis=1).max())
        if longest < shortest:
            best, shortest = q, longest
        if shortest < TOLERANCE:
            return JointState(joints, best[columns])
    distances = np.linalg.norm(tips.places(best) - wanted, axis=1)
    far = {name: float(d) for name, d in zip(tips.fingers, distances, strict=True) if d >= TOLERANCE}
    words = ", ".join(f"{name} stays {1000 * d:.0f} mm away" for name, d in far.items())
    raise NoIkError(f"the hand can't reach these fingertip positions: {words}", distances=far)


def fingers_of(model: RobotModel, group: str) -> dict[str, str]:
    """Return finger -> link of its tip, of the fingers that a hand's joints move."""
    links = {finger: links[-1] for finger, links in model.description.finger_links.items()}
    return {finger: tip for finger, tip in links.items() if _moved_by(model, tip, group)}


def _moved_by(model: RobotModel, frame: str, group: str) -> bool:
    """Tell whether a group's joints move a frame."""
    joints = {model.model.getJointId(name) for name in model.description.group(group)}
    return bool(joints & set(model.model.supports[model.model.frames[model.model.getFrameId(frame)].parentJoint]))


class _Tips:
    """The frames of some fingers' tips or other links, seen from a frame of the palm."""

    def __init__(self, model: RobotModel, names: tuple[str, ...], group: str, frame: str):
        self.model, self.data = model.model, model.model.createData()
        self.fingers = names
        tips, robot = fingers_of(model, group), model.description.name
        links = [str(f.name) for f in self.model.frames if f.type == pin.FrameType.BODY]
        moved = {link for link in links if _moved_by(model, link, group)}
        for name in names:
            if name not in tips and name not in moved:
                raise UnknownNameError("finger or link of the hand", name, (*tips, *sorted(moved)), robot)
        grasps = [str(f.name) for f in self.model.frames if str(f.name).split("/")[0] == GRASP_FRAME]
        joints = [self.model.getJointId(name) for name in model.description.group(group)]
        palm = self.model.parents[min(joints)]  # what carries the hand: the parent of its joint nearest to the base
        still = [n for n in (*grasps, *links) if self.model.frames[self.model.getFrameId(n)].parentJoint == palm]
        if frame not in still:
            raise UnknownNameError("frame of the palm", frame, still, robot)
        self.frames = [self.model.getFrameId(tips.get(name, name)) for name in names]
        self.palm = self.model.getFrameId(frame)

    def places(self, q: Array) -> Array:
        """Return the tips' positions in the grasp frame, shape (k, 3)."""
        pin.framesForwardKinematics(self.model, self.data, q)
        palm = self.data.oMf[self.palm]
        return np.array([palm.actInv(self.data.oMf[tip].translation) for tip in self.frames]).reshape(-1, 3)

    def jacobian(self, q: Array, columns: NDArray[np.int64]) -> Array:
        """Return how the positions change with the joints in `columns`, which don't move the palm, shape (3 k, m)."""
        pin.computeJointJacobians(self.model, self.data, q)
        turn = self.data.oMf[self.palm].rotation.T
        rows = []
        for tip in self.frames:
            frame = pin.getFrameJacobian(self.model, self.data, tip, pin.LOCAL_WORLD_ALIGNED)
            rows.append(turn @ frame[:3, columns])
        return np.vstack(rows)


_OPPOSED = 0.02
"""Fingers whose tips are this much further from the thumb's than the nearest don't oppose it [m]."""
_PROBE, _SLACK, _STEP, _DEEPEST = 0.012, (-0.001, 0.005), 0.004, 0.12
"""A bar is pushed in between the fingers: its thickness, how much thinner it is than the gap on each side, for links
that are to stay clear of things and for tips, which may be round, its steps, and its way [m]."""
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
        found.append(replace(span, depth=_depth(span, placed, {thumb, *fingers})))
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


def _depth(span: Span, placed: Mapping[str, Sequence[_Placed]], tips: Collection[str]) -> float:
    bars = [coal.Box(max(span.gap - 2 * slack, _PROBE), _PROBE, _PROBE) for slack in _SLACK]
    turned = np.stack([span.axis, np.cross(span.inward, span.axis), span.inward], axis=1)
    around = [(bars[name in tips], each) for name, shapes in placed.items() for each in shapes]
    for deep in np.arange(_STEP, _DEEPEST, _STEP):
        there = pin.SE3(turned, span.middle - deep * span.inward)
        if any(_nearest((bar, there), each)[0] < 0 for bar, each in around):
            return float(deep - _STEP + _PROBE / 2)
    return _DEEPEST
