"""A hand's posture from where its fingertips shall be: one damped least squares descent for all fingers together.

A fingertip is the origin of a finger's last link. Its orientation doesn't matter: a finger of four joints can place
its tip and not much more.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from grip_bt.errors import NoIkError, UnknownNameError
from grip_bt.values import JointState

from ..model import GRASP_FRAME, RobotModel

TOLERANCE = 1e-3
"""Largest distance of a fingertip from its target [m]."""
_FINISHED = 1e-5
_STEPS = 60
_RESTARTS = 12
_DAMPING = 1e-5
_MAX_STEP = 0.4


def fingertip_positions(model: RobotModel, hand: JointState) -> dict[str, NDArray[np.float64]]:
    """Return where each finger's tip is, in the grasp frame, shape (3,) [m]."""
    tips = _Tips(model, model.description.finger_links)
    places = tips.places(model.configuration(hand))
    return dict(zip(tips.fingers, places, strict=True))


def fingertip_posture(
    model: RobotModel,
    targets: Mapping[str, NDArray[np.float64]],
    seed: JointState | None = None,
    group: str = "hand",
    rng: np.random.Generator | None = None,
) -> JointState:
    """Return positions of a hand's joints that bring its fingertips to their targets.

    Joints that move none of these fingers stay where `seed` has them.

    Args:
        model: the robot.
        targets: finger -> wanted position of its tip in the grasp frame, shape (3,) [m].
        seed: posture to begin at, and to stay near; the hand's `open` one when it isn't given.
        group: the hand's group of joints.
        rng: where restarts come from; seeded with 0 when it isn't given, so that the same question has the same answer.

    Raises:
        UnknownNameError: there is no such finger.
        NoIkError: a tip stays further than 1 mm from its target; `data['distances']` tells how far, by finger.
    """
    if unknown := [name for name in targets if name not in model.description.finger_links]:
        raise UnknownNameError("finger", unknown[0], model.description.finger_links, model.description.name)
    tips = _Tips(model, targets)
    wanted = np.array([targets[name] for name in tips.fingers], dtype=float).reshape(len(tips.fingers), 3)
    joints = model.description.group(group)
    columns = np.array([model.model.joints[model.model.getJointId(name)].idx_q for name in joints])
    begin = seed or model.description.named_state(group, "open")
    best, shortest = model.configuration(begin), np.inf
    for start in _starts(model, begin, columns, rng or np.random.default_rng(0)):
        q = _descended(model, tips, wanted, start, columns)
        longest = float(np.linalg.norm(tips.places(q) - wanted, axis=1).max())
        if longest < shortest:
            best, shortest = q, longest
        if shortest < TOLERANCE:
            return JointState(joints, best[columns])
    distances = np.linalg.norm(tips.places(best) - wanted, axis=1)
    far = {name: float(d) for name, d in zip(tips.fingers, distances, strict=True) if d >= TOLERANCE}
    words = ", ".join(f"{name} stays {1000 * d:.0f} mm away" for name, d in far.items())
    raise NoIkError(f"the hand can't reach these fingertip positions: {words}", distances=far)


class _Tips:
    """The frames of some fingers' tips, seen from the grasp frame."""

    def __init__(self, model: RobotModel, fingers: Mapping[str, object]):
        self.model, self.data = model.model, model.model.createData()
        self.fingers = tuple(fingers)
        links = model.description.finger_links
        self.frames = [self.model.getFrameId(links[name][-1]) for name in self.fingers]
        self.palm = self.model.getFrameId(GRASP_FRAME)

    def places(self, q: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the tips' positions in the grasp frame, shape (k, 3)."""
        pin.framesForwardKinematics(self.model, self.data, q)
        palm = self.data.oMf[self.palm]
        return np.array([palm.actInv(self.data.oMf[tip].translation) for tip in self.frames]).reshape(-1, 3)

    def jacobian(self, q: NDArray[np.float64], columns: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return how the positions change with the joints in `columns`, which don't move the palm, shape (3 k, m)."""
        pin.computeJointJacobians(self.model, self.data, q)
        turn = self.data.oMf[self.palm].rotation.T
        rows = []
        for tip in self.frames:
            frame = pin.getFrameJacobian(self.model, self.data, tip, pin.LOCAL_WORLD_ALIGNED)
            rows.append(turn @ frame[:3, columns])
        return np.vstack(rows)


def _starts(
    model: RobotModel, begin: JointState, columns: NDArray[np.int64], rng: np.random.Generator
) -> Iterator[NDArray[np.float64]]:
    first = model.configuration(begin)
    yield first
    for _ in range(_RESTARTS):
        q = first.copy()
        q[columns] = rng.uniform(model.model.lowerPositionLimit[columns], model.model.upperPositionLimit[columns])
        yield q


def _descended(
    model: RobotModel, tips: _Tips, wanted: NDArray[np.float64], q: NDArray[np.float64], columns: NDArray[np.int64]
) -> NDArray[np.float64]:
    lower, upper = model.model.lowerPositionLimit[columns], model.model.upperPositionLimit[columns]
    q = q.copy()
    for _ in range(_STEPS):
        error = (wanted - tips.places(q)).ravel()
        if np.abs(error).max() < _FINISHED:
            break
        jacobian = tips.jacobian(q, columns)
        step = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + _DAMPING * np.eye(len(error)), error)
        # Joint by joint: a finger that is far from its target must not slow down the others.
        q[columns] = np.clip(q[columns] + np.clip(step, -_MAX_STEP, _MAX_STEP), lower, upper)
    return q
