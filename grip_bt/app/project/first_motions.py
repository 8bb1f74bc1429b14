"""Which motions a robot's first task makes: its named states, a pose and a line that it is known to reach."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.failures import ExpectedError
from grip_bt.base.values import JointState, Pose
from grip_bt.commanders.description.robot import RESTING, RobotDescription
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.commanders.planning.answer import plan_to
from grip_bt.commanders.planning.checks import chain_and_checker
from grip_bt.commanders.planning.requests import PlanStraight, PlanTo, Situation
from grip_bt.commanders.planning.straight import plan_straight
from grip_bt.commanders.scene_state import SceneSnapshot
from grip_bt.commanders.settings import PlanningSettings

TRIES = 40
"""Postures that are drawn in search of one from which the hand can go straight."""
PLANS = 6
"""Of them, those that a plan is searched for: it takes up to two seconds each."""
LINES = ((0, 0, 0.05), (0, 0, -0.05), (-0.05, 0, 0), (0, 0.05, 0), (0.05, 0, 0), (0, 0, 0.02), (-0.02, 0, 0))
"""Offsets [m] that are tried."""


@dataclass(frozen=True)
class FirstMotions:
    """What an arm does first.

    Attributes:
        home: where it rests, where the robot's files don't say it or something touches there; joint -> [rad or m].
        states: named states that nothing touches in.
        touching: named state -> pairs of links that touch.
        pose: one that it reaches, in world; None where none was found.
        line: from there, x, y, z in world [m].
    """

    home: Mapping[str, float] = field(default_factory=dict)
    states: tuple[str, ...] = ()
    touching: Mapping[str, tuple[tuple[str, str], ...]] = field(default_factory=dict)
    pose: Pose | None = None
    line: tuple[float, float, float] | None = None


class MotionFinder:
    """Tries motions of a robot's arms in an empty room.

    Args:
        robot: its description.
    """

    def __init__(self, robot: RobotDescription):
        self.robot, self.model = robot, RobotModel(robot)

    def of(self, group: str) -> FirstMotions:
        """Return what the arm of a group does first; the other joints are at rest."""
        at_rest = self.robot.at_rest
        rest = JointState(self.robot.joints, [at_rest.get(j, 0.0) for j in self.robot.joints])
        self.situation = Situation(group, rest, SceneSnapshot(), "", PlanningSettings())
        self.chain, self.checker = chain_and_checker(self.model, self.situation, 0.0)
        named = {name: s.ordered(self.chain.joints) for name, s in self.robot.named_states.get(group, {}).items()}
        free = {name: q for name, q in named.items() if self.checker.free(q)}
        touching = {name: self.checker.pairs(q) for name, q in named.items() if name not in free}
        known = next((name for name in RESTING if name in named), None)
        start = rest.ordered(self.chain.joints)
        home: Mapping[str, float] = {}
        if known is None or known not in free or not self.checker.free(start):
            start = next((q for q in (start, *free.values(), *self._drawn()) if self.checker.free(q)), start)
            home = dict(zip(self.chain.joints, start.round(6).tolist(), strict=True))
            touching.pop("home", None)  # it has another one now
        states = tuple(dict.fromkeys([*(["home"] if home else []), *free]))
        last = start if states in ((), ("home",)) else free[states[-1]]  # where the task is before the pose
        pose, line = self._pose_and_line(last, [start, *free.values()])
        return FirstMotions(home, states, touching, pose, line)

    def _drawn(self) -> Iterator[Array]:
        low, high = self.chain.limits.lower, self.chain.limits.upper
        middle, rng = np.clip(0.0, low, high), np.random.default_rng(0)
        for share in np.linspace(0.2, 1.0, TRIES):  # near zero first
            yield middle + share * (rng.uniform(low, high) - middle)

    def _pose_and_line(
        self, start: Array, states: list[Array]
    ) -> tuple[Pose | None, tuple[float, float, float] | None]:
        """Return a pose that a plan leads to from `start`, and a line from there."""
        reached: Pose | None = None
        plans = 0
        for q in (*states, *self._drawn()):
            if not self.checker.free(q):
                continue
            goal = Pose.from_matrix(self.chain.grasp_pose(q).homogeneous)
            goal = Pose(np.round(goal.position, 4), np.round(goal.quaternion, 4))
            lines = [offset for offset in LINES if self._straight(q, goal, offset)]
            if not lines and reached is not None:
                continue
            if (plans := plans + 1) > PLANS:
                break
            try:
                there = plan_to(self.model, PlanTo(self._at(start), goal), lambda: False).positions[-1]
            except ExpectedError:
                continue
            reached = reached or goal
            for offset in lines:
                if self._straight(there, goal, offset):
                    return goal, offset
        return reached, None

    def _at(self, q: Array) -> Situation:
        start = self.situation.start.as_mapping() | dict(zip(self.chain.joints, q.tolist(), strict=True))
        return replace(self.situation, start=JointState.from_mapping(start))

    def _straight(self, q: Array, begin: Pose, offset: tuple[float, float, float]) -> bool:
        try:
            plan_straight(self.model, PlanStraight(self._at(q), (begin.moved(offset),)))
        except ExpectedError:
            return False
        return True
