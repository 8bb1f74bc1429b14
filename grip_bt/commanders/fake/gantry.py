"""A fake arm: a gantry whose six joints are the position and the rotation vector of its grasp frame.

It reaches every pose and knows no obstacle; everything else is `ArmCommander`. Joints of a robot go where joint goals
say, but move no hand.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.failures import ConstraintBrokenError, ExpectedError, NoGraspError
from grip_bt.base.operation import Operation
from grip_bt.base.values import Grasp, JointState, PathConstraint, Plan, Pose, Trajectory
from grip_bt.base.values.pose import quaternion_about

from ..arm import ArmCommander, ArmSetup
from ..joined import require_joints
from ..planning import requests
from ..scene import PlanningScene
from ..steered_motion import velocity_of
from ..steering import jogged, steered
from ..taught import TaughtStates
from .joints import FakeExecutor

JOINTS = ("x", "y", "z", "rx", "ry", "rz")
SPEED = 0.5
"""Of each joint [m/s or rad/s]."""
ACCELERATION = 2.0
"""Of each joint while it is steered [m/s^2 or rad/s^2]."""
_MOMENT = 1e-3


class FakeArm(ArmCommander):
    """Implements `ports.Arm`.

    Args:
        name: the arm's name in the project.
        home: pose of the grasp frame in the state `home`, where it is at first.
        states: further named states of the joints `JOINTS`.
        taught: what was taught before; nothing when None.
        own: where the robot's own joints are at first; it has none when None.
        executor: makes what moves the joints, of where they are at first.

    Attributes:
        load: what its wrist bears; see `ports.Arm.wrench`.
    """

    def __init__(
        self,
        name: str = "right",
        home: Pose | None = None,
        states: Mapping[str, JointState] | None = None,
        taught: TaughtStates | None = None,
        own: JointState | None = None,
        executor: Callable[[JointState], FakeExecutor] = FakeExecutor,
    ):
        own, pose = own or JointState((), ()), home or Pose([0.3, -0.4, 0.5])
        start = JointState((*own.names, *JOINTS), [*own.position, *_joints_of(pose)])
        self._gantry = executor(start)
        known = {"home": start, **(states or {})}
        setup = ArmSetup(name, "gantry", states=known, taught=taught if taught is not None else TaughtStates())
        planner = _GantryPlanner(name, start.names)
        self.load = np.zeros(6)
        super().__init__(setup, _GantryGeometry(), planner, self._gantry, PlanningScene({}), wrench=lambda: self.load)

    def put_back(self, position: Array) -> None:
        """Have the joints where they were, when nothing is under way.

        Args:
            position: of the robot's own joints, then of `JOINTS`.

        Raises:
            ValueError: it has another shape.
        """
        self._gantry.put_back(position)

    def _situation(self, given: JointState | None = None) -> requests.Situation:
        """Return it with those joints of `given` that it names; the others are where they are measured."""
        state = self.state()
        position = state.position if given is None else _row(self.name, state.names, state.position, given)
        return super()._situation(replace(state, position=position))


class _GantryGeometry:
    """Implements `RobotGeometry`: the last six joints are the grasp frame; the robot's own move nothing."""

    def grasp_pose(self, *states: JointState, group: str = "") -> Pose:
        return _pose_of(states[0].position)

    def limits_of(self, names: tuple[str, ...]) -> None:
        return None

    def named_states_of(self, group: str) -> Mapping[str, JointState]:
        return {}


class _GantryPlanner:
    """Implements `PlanningService`: straight motions of the joints, at once."""

    def __init__(self, arm: str, joints: tuple[str, ...]):
        self._arm, self._joints = arm, joints

    def submit(self, request: requests.Request) -> Operation[Plan | requests.ChosenGrasp | None]:
        if isinstance(request, requests.CheckTogether):
            return Operation.finished(None)  # fakes know no shapes
        answer = self._answer(request)
        return Operation.failed(answer) if isinstance(answer, ExpectedError) else Operation.finished(answer)

    def _answer(self, request: requests.Request) -> Plan | requests.ChosenGrasp | ExpectedError:
        begin = request.situation.start.position
        match request:
            case requests.PlanTo():
                end = self._end(request.goal, begin)
                return _broken(request.constraint, {"start": begin, "goal": end}) or self._through(begin, [end])
            case requests.PlanStraight():
                return self._through(begin, [self._end(pose, begin) for pose in request.poses])
            case requests.PlanThrough():
                rows = [begin]
                for point in request.way_points:
                    rows.append(self._end(point.goal, rows[-1]))
                named = {"start": begin, **{f"way point {k}": end for k, end in enumerate(rows[1:], 1)}}
                plan = self._through(begin, rows[1:])
                return _broken(request.constraint, named) or replace(plan, radii=(0.0,) * (len(rows) - 2))
            case requests.CheckTrajectory(trajectory=given):
                table = np.tile(begin, (len(given.times), 1))
                table[:, [self._joints.index(name) for name in given.names]] = given.positions
                return Plan("gantry", Trajectory(self._joints, given.times, table), "given")
            case requests.PlanServoStep():
                return Plan("gantry", self._step(request), "fake")
            case requests.ChooseGrasp(grasps=grasps) if grasps:
                best: Grasp = max(grasps, key=lambda grasp: grasp.quality)
                before, there = (
                    JointState(self._joints, self._end(pose, begin)) for pose in (best.pre_grasp, best.pose)
                )
                return requests.ChosenGrasp(best, before, there)
            case _:
                return NoGraspError("none of 0 grasps is feasible", reasons={}, candidates=0)

    def _end(self, goal: JointState | Pose | str | tuple[Pose, ...], begin: Array) -> Array:
        assert not isinstance(goal, str), "names of states are looked up before"
        goal = goal[0] if isinstance(goal, tuple) else goal
        state = JointState(JOINTS, _joints_of(goal)) if isinstance(goal, Pose) else goal
        return _row(self._arm, self._joints, begin, state)

    def _through(self, begin: Array, ends: Sequence[Array]) -> Plan:
        rows, times = [begin], [0.0]
        for end in ends:
            span = float(np.abs(end - rows[-1]).max())
            if span > 0:
                times.append(times[-1] + span / SPEED)
                rows.append(end)
        return Plan("gantry", Trajectory(self._joints, np.array(times), np.stack(rows)), "fake")

    def _step(self, request: requests.PlanServoStep) -> Trajectory:
        start = request.situation.start

        def wanted(q: Array) -> Array:
            there = jogged(_pose_of(q), request.linear, request.angular, _MOMENT)
            rates = (_joints_of(there) - q[-len(JOINTS) :]) / _MOMENT
            still = np.zeros(len(q) - len(rates))
            return np.concatenate([still, rates / max(1.0, float(np.abs(rates).max()) / SPEED)])

        limits = np.full(len(self._joints), ACCELERATION)
        return steered(self._joints, start.position, velocity_of(start, self._joints), wanted, limits, request.hold)


def _row(arm: str, joints: Sequence[str], begin: Array, state: JointState) -> Array:
    """Return the positions of all joints, shape (n,); those that aren't named are where they were."""
    row, named = np.array(begin), state.as_mapping()
    require_joints(tuple(named), joints, arm)
    row[[joints.index(name) for name in named]] = list(named.values())
    return row


def _joints_of(pose: Pose) -> Array:
    """Return position and rotation vector, shape (6,); the vector's length is the angle, at most pi [rad]."""
    return np.concatenate([pose.position, pose.rotation_vector()])


def _pose_of(joints: Array) -> Pose:
    return Pose(joints[-6:-3], quaternion_about(joints[-3:]))


def _broken(constraint: PathConstraint | None, rows: Mapping[str, Array]) -> ConstraintBrokenError | None:
    """Return the error for the first of some named rows of joints that breaks a constraint, or None."""
    for what, joints in rows.items():
        if constraint is not None and not constraint.kept_by(_pose_of(joints)):
            return ConstraintBrokenError(f"the {what} violates the path constraint; widen its tolerances or its box")
    return None
