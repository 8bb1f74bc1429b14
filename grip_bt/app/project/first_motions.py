"""What a robot's first tasks do: motions that it is known to make, and a first grasp of a thing on a bench."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from string import Template

import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array
from grip_bt.base.failures import ExpectedError
from grip_bt.base.values import Grasp, JointState, Pose
from grip_bt.base.values.solids import Box
from grip_bt.commanders.description.robot import RESTING, RobotDescription
from grip_bt.commanders.kinematics.model import RobotModel, link_of
from grip_bt.commanders.planning.answer import plan_to
from grip_bt.commanders.planning.checks import chain_and_checker
from grip_bt.commanders.planning.grasps import choose_grasp
from grip_bt.commanders.planning.requests import PlanStraight, PlanTo, Situation
from grip_bt.commanders.planning.straight import plan_straight
from grip_bt.commanders.scene_state import SceneObject, SceneSnapshot
from grip_bt.commanders.settings import PlanningSettings
from grip_bt.task import fmt

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
    """Tries motions of a robot's arms.

    Args:
        robot: its description.
        room: what stands around it.
    """

    def __init__(self, robot: RobotDescription, room: SceneSnapshot):
        self.robot, self.model, self.room = robot, RobotModel(robot), room

    def of(self, group: str) -> FirstMotions:
        """Return what the arm of a group does first; the other joints are at rest."""
        at_rest = self.robot.at_rest
        rest = JointState(self.robot.joints, [at_rest.get(j, 0.0) for j in self.robot.joints])
        self.situation = Situation(group, rest, self.room, "", PlanningSettings())
        self.chain, self.checker = chain_and_checker(self.model, self.situation)
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


_FILES = Path(__file__).with_name("bench")
PLACES = tuple(product((0.45, 0.38, 0.55, 0.65), (0.1, -0.1, 0.25, -0.25)))
"""Where the thing may stand, x and y in world [m]."""
BENCH = SceneSnapshot().with_object(SceneObject("bench", Box((0.7, 1.2, 0.1)), Pose([0.65, 0.0, -0.05]), fixed=True))
APPROACH, LIFT = 0.1, 0.15
GAP = 0.04
"""Height above the bench that fingertips keep when they come from above [m]."""
BLOCK, CAN = "model: block", "shape: cylinder, radius: 0.03, height: 0.15, mass: 0.2"
BESIDE_CAN = np.array([0.018, 0.0, 0.034])
"""The can's axis in the grasp frame of a palm that takes it from the side, `PALM_HEIGHT` above the bench [m]."""
PALM_HEIGHT = 0.09


def first_grasp(robot: RobotDescription, name: Callable[[str], str]) -> dict[str, str]:
    """Return the files of a world and a task in which a hand takes something; none where no arm can.

    Args:
        robot: with a state `home` of each arm, or another one in which it rests.
        name: returns what a group is called in the project.
    """
    model, rest = RobotModel(robot), robot.at_rest
    start = JointState(robot.joints, [rest.get(joint, 0.0) for joint in robot.joints])
    shown = {link_of(model.model, each) for each in model.geometry.geometryObjects}
    for end in robot.end_effectors:
        arm, mine = end.parent_group, set(robot.hands.get(end.group, ()))
        fingers = [links for links in robot.finger_links.values() if shown & mine & set(links)]
        state = next((name for name in RESTING if name in robot.named_states.get(arm, {})), None)
        if not fingers or state is None:
            continue
        can = len(fingers) > 2
        middle = BESIDE_CAN if can else _between(model, arm, fingers)
        situation = Situation(arm, start, BENCH, "", PlanningSettings())
        for x, y in PLACES:
            try:
                found = choose_grasp(model, situation, tuple(_grasps(x, y, middle, can)), lambda: False).grasp
            except ExpectedError:
                continue
            hand = f"hand: {name(end.group)}"
            said = {"thing": "can" if can else "block", "shape": CAN if can else BLOCK, "x": x, "y": y}
            said |= {key: getattr(found.pose, key).round(4).tolist() for key in ("position", "quaternion")}
            # Two fingers press by a force; more of them close to their torque limits.
            # One of several robots can't go out of the others' way.
            hidden = ", max_hidden: 0.05" if len({e.parent_group for e in robot.end_effectors}) > 1 else ""
            said["seen"] = hidden + (f", state: {state}" if state != "home" else "")
            said |= {"arm": name(arm), "hand": name(end.group), "close": hand if can else f"{hand}, force: 10"}
            texts = {f: Template((_FILES / f).read_text("utf-8")).substitute(said) for f in ("bench.yaml", "take.yaml")}
            return {"worlds/bench.yaml": texts["bench.yaml"], "tasks/take.yaml": fmt(texts["take.yaml"], "take.yaml")}
    return {}


def _between(model: RobotModel, group: str, fingers: list[tuple[str, ...]]) -> Array:
    """Return what is between the open fingers, at their tips, in the grasp frame [m], shape (3,)."""
    state = model.description.opened(group)
    links = {link for each in fingers for link in each}
    shapes = zip(model.geometry.geometryObjects, model.hulls(state), strict=True)
    points = np.vstack([points for shape, points in shapes if link_of(model.model, shape) in links])
    inside = model.grasp_pose(state, group=group).inverse().apply(points)
    low, high = inside.min(axis=0), inside.max(axis=0)
    return np.array([*(low + high)[:2] / 2, high[2]])


def _grasps(x: float, y: float, middle: Array, can: bool) -> Iterator[Grasp]:
    turns = (0, 90, 180, 270, *((45, 135, 225, 315) if can else ()))
    for number, turn in enumerate(np.radians(turns)):
        c, s = np.cos(turn), np.sin(turn)
        if can:  # the palm's normal is level, the fingers go round it either way
            every = [np.column_stack([[-up * s, up * c, 0.0], [0.0, 0.0, up], [c, s, 0.0]]) for up in (1.0, -1.0)]
        else:
            every = [np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]])]
        for axes in every:
            at = np.array([x, y, PALM_HEIGHT if can else GAP]) - axes @ middle
            pose = Pose.from_matrix(pin.SE3(axes, at).homogeneous)
            yield Grasp(pose, pose.moved(-APPROACH * axes[:, 2]), pose.moved((0.0, 0.0, LIFT)), quality=-number)
