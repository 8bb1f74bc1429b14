"""Fingers: joints that bring their tips to targets, and what lies between them, measured on their collision shapes."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

import coal
import numpy as np
import pinocchio as pin

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
    placed, rng = _tips(model, targets, group, frame), np.random.default_rng(0)
    wanted = np.array(list(targets.values()), dtype=float).reshape(-1, 3)
    joints = model.description.group(group)
    columns = [model.model.joints[model.model.getJointId(name)].idx_q for name in joints]
    lower, upper = model.model.lowerPositionLimit[columns], model.model.upperPositionLimit[columns]
    first = model.configuration(seed or model.description.named_state(group, "open"))
    best, distances = first, np.full(len(wanted), np.inf)
    for start in (first[columns], *(rng.uniform(lower, upper) for _ in range(_RESTARTS))):
        q = first.copy()
        q[columns] = start
        for _ in range(_STEPS):
            places, jacobian = placed(q)
            error, jacobian = (wanted - places).ravel(), jacobian[:, columns]
            if np.abs(error).max() < _FINISHED:
                break
            step = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + _DAMPING * np.eye(len(error)), error)
            # Joint by joint: a finger that is far from its target must not slow down the others.
            q[columns] = np.clip(q[columns] + np.clip(step, -_MAX_STEP, _MAX_STEP), lower, upper)
        missed = np.linalg.norm(placed(q)[0] - wanted, axis=1)
        if missed.max() < distances.max():
            best, distances = q, missed
        if distances.max() < TOLERANCE:
            return JointState(joints, best[columns])
    far = {name: float(d) for name, d in zip(targets, distances, strict=True) if d >= TOLERANCE}
    words = ", ".join(f"{name} stays {1000 * d:.0f} mm away" for name, d in far.items())
    raise NoIkError(f"the hand can't reach these fingertip positions: {words}", distances=far)


def _tips(model: RobotModel, names: Collection[str], group: str, frame: str) -> Callable[[Array], tuple[Array, Array]]:
    """Return what tells, for all joints, where the tips of fingers or other links are in a frame of the palm.

    It returns their positions, shape (k, 3), and how these change with the joints, shape (3 k, n).
    """
    pins, data, robot = model.model, model.model.createData(), model.description
    moving = [pins.getJointId(name) for name in robot.group(group)]

    def moved(link: str) -> bool:
        return not set(moving).isdisjoint(pins.supports[pins.frames[pins.getFrameId(link)].parentJoint])

    links = [str(f.name) for f in pins.frames if f.type == pin.FrameType.BODY]
    own = {link: link for link in links if moved(link)}
    known = {finger: tip for finger, (*_, tip) in robot.finger_links.items() if tip in own} | own
    for name in names:
        if name not in known:
            raise UnknownNameError("finger or link of the hand", name, known, robot.name)
    grasps = [str(f.name) for f in pins.frames if str(f.name).split("/")[0] == GRASP_FRAME]
    carrier = pins.parents[min(moving)]  # what carries the hand: the parent of its joint nearest to the base
    still = [n for n in (*grasps, *links) if pins.frames[pins.getFrameId(n)].parentJoint == carrier]
    if frame not in still:
        raise UnknownNameError("frame of the palm", frame, still, robot.name)
    tips, palm = [pins.getFrameId(known[name]) for name in names], pins.getFrameId(frame)

    def placed(q: Array) -> tuple[Array, Array]:
        pin.computeJointJacobians(pins, data, q)
        pin.updateFramePlacements(pins, data)
        here = data.oMf[palm]
        rows = [pin.getFrameJacobian(pins, data, tip, pin.LOCAL_WORLD_ALIGNED)[:3] for tip in tips]
        places = np.array([here.actInv(data.oMf[tip].translation) for tip in tips]).reshape(-1, 3)
        return places, np.vstack([here.rotation.T @ row for row in rows])

    return placed


_OPPOSED = 0.02
"""Fingers whose tips are this much further from the thumb's than the nearest don't oppose it [m]."""
_PROBE, _SLACK, _STEP, _DEEPEST = 0.012, (-0.001, 0.005), 0.004, 0.12
"""A bar is pushed in between the fingers: its thickness, how much thinner it is than the gap on each side, for links
that are to stay clear of things and for tips, which may be round, its steps, and its way [m]."""
_KEPT = 1024
"""Postures of which a model keeps what was measured, the newest ones."""
_Placed = tuple[coal.CollisionGeometry, pin.SE3]
_Pressed = tuple[str, Array, Array]
"""A link, where it presses, and with which force, if the thumb's is 1; in the grasp frame."""


def spans_of(model: RobotModel, group: str, frame: str, postures: Sequence[JointState]) -> list[Span]:
    """Return what is between a hand's fingers in some postures, seen from a grasp frame.

    The last of its fingers is the thumb, or one of a gripper's two. What was measured is kept with the model.

    Raises:
        ValueError: it has less than two fingers.
    """
    hand = frozenset(model.description.hands[group])
    *fingers, thumb = [each[-1] for each in model.description.finger_links.values() if each[-1] in hand] or ("",)
    if not fingers:
        raise ValueError(f"hand {group!r} of {model.description.name} has less than two fingers, none to grasp between")
    data, shapes = model.model.createData(), model.geometry.geometryObjects
    palm_joint = model.model.frames[model.model.getFrameId(frame)].parentJoint
    linked = [(link_of(model.model, shape), shape) for shape in shapes]  # what the palm is fixed to is in the way too
    near = [(link, shape) for link, shape in linked if link in hand or shape.parentJoint == palm_joint]

    def measured(posture: JointState) -> Span:
        q = model.configuration(posture)
        pin.computeJointJacobians(model.model, data, q)
        pin.framesForwardKinematics(model.model, data, q)
        palm = data.oMf[model.model.getFrameId(frame)].inverse()
        placed: dict[str, list[_Placed]] = {}
        points = []
        for link, shape in near:
            body = palm * data.oMi[shape.parentJoint]
            placed.setdefault(link, []).append((shape.geometry, body * shape.placement))
            points.append(corners(shape) @ body.rotation.T + body.translation)
        gap, middle, axis, pressed = _between(placed, fingers, thumb)
        squeezing = _squeezing(model, data, palm, posture, pressed)
        span = Span(posture, gap, middle, axis, 0.0, np.concatenate(points), squeezing)
        return replace(span, depth=_depth(span, placed, {thumb, *fingers}))

    keys = [(group, frame, posture.names, posture.position.tobytes()) for posture in postures]
    found = {key: model.spans.get(key) or measured(each) for key, each in zip(keys, postures, strict=True)}
    model.spans = dict([*(model.spans | found).items()][-_KEPT:])
    return [found[key] for key in keys]


def _between(
    placed: Mapping[str, Sequence[_Placed]], fingers: Sequence[str], thumb: str
) -> tuple[float, Array, Array, list[_Pressed]]:
    """Return the gap, its middle, the direction from the thumb to the fingers across their line, and how they squeeze.

    What the fingers press together goes through the thumb's point as nearly as they can share it, or else they would
    turn what they hold about it.
    """
    nearest = []
    for finger in fingers:
        each = (_nearest(one, other) for one in placed[thumb] for other in placed[finger])
        nearest.append((*min(each, key=lambda found: found[0]), finger))
    gap = min(found[0] for found in nearest)
    opposed = [found for found in nearest if found[0] < gap + _OPPOSED]
    near = np.mean([found[1] for found in opposed], axis=0)
    tips = np.array([found[2] for found in opposed])
    away = (tips.mean(axis=0) - near) * (1.0 if gap >= 0 else -1.0)
    if len(tips) > 1:
        line = np.linalg.svd(tips - tips.mean(axis=0))[2][0]
        away = away - line * (line @ away)
    axis = away / max(float(np.linalg.norm(away)), 1e-9)
    aside = (tips - near - np.outer((tips - near) @ axis, axis)) / _OPPOSED
    shares = np.linalg.lstsq(np.column_stack([aside, np.ones(len(tips))]).T, np.eye(4)[3], rcond=None)[0].clip(0)
    shares /= shares.sum()
    against = [(found[3], found[2], -share * axis) for found, share in zip(opposed, shares, strict=True)]
    return gap, (near + shares @ tips) / 2, axis, [(thumb, near, axis), *against]


def _squeezing(
    model: RobotModel, data: pin.Data, palm: pin.SE3, posture: JointState, pressed: Sequence[_Pressed]
) -> JointState:
    """Return what joints aim at to press from a posture: each is off by what its servo, a spring, turns into J^T f.

    They press as hard as the joint can that comes to its limit first.
    """
    torque = np.zeros(model.model.nv)
    for link, place, force in pressed:
        joint = model.model.frames[model.model.getFrameId(link)].parentJoint
        there, along = palm.actInv(place), palm.rotation.T @ force
        torque += pin.getJointJacobian(model.model, data, joint, pin.WORLD).T @ [*along, *np.cross(there, along)]
    drives = [model.description.drives[name] for name in posture.names]
    asked = torque[[model.model.joints[model.model.getJointId(name)].idx_v for name in posture.names]]
    strongest = np.abs(asked / [drive.limit for drive in drives]).max()
    off = asked / [drive.stiffness for drive in drives] / max(float(strongest), 1e-9)
    return JointState(posture.names, posture.position + off)


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
