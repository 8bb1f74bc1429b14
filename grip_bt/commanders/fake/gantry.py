"""A fake arm: a gantry whose six joints are the position and the rotation vector of its grasp frame.

It reaches every pose and knows no obstacle, so that tasks can be run without models; the rest of its behaviour is
that of `ArmCommander`. Joints of a robot, where it is told their names, go where joint goals say, but move no hand:
that would take a model.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import ConstraintBrokenError, ExpectedError, NoGraspError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import FREEDOMS
from grip_bt.base.values import Grasp, JointState, PathConstraint, Plan, Pose, Trajectory, WayPoint

from ..joined import require_joints
from ..pausing import PausableExecutor
from ..steered_motion import SteeredMotion, Twist, velocity_of
from ..steering import HOLD, approaching, bounded, jogged, lasting, steered
from ..taught import TaughtStates
from .joints import AtOnce, FakeExecutor, Schedule, Script, steps_of

JOINTS = ("x", "y", "z", "rx", "ry", "rz")
PLANNING = ("plan", "plan_straight", "plan_through", "plan_from_trajectory", "plan_step", "choose_grasp")
SPEED = 0.5
"""Of each joint [m/s or rad/s]."""
ACCELERATION = 2.0
"""Of each joint while it is steered [m/s^2 or rad/s^2]."""
_MOMENT = 1e-3


class FakeArm:
    """Implements `ports.Arm`.

    Args:
        name: the arm's name in the project.
        home: pose of the grasp frame in the state `home`, where it is at first.
        schedule: its time; at once when None.
        states: further named states of the joints `JOINTS`.
        script: verb (`plan`, `plan_straight`, `plan_through`, `plan_from_trajectory`, `plan_step`, `choose_grasp`,
            `execute`) -> what becomes of each such request; `plan_step` is asked while the arm is steered.
        taught: what was taught before; nothing when None.
        own: where the robot's own joints are at first; it has none when None.
    """

    def __init__(
        self,
        name: str = "right",
        home: Pose | None = None,
        schedule: Schedule | None = None,
        states: Mapping[str, JointState] | None = None,
        script: Mapping[str, Script] | None = None,
        taught: TaughtStates | None = None,
        own: JointState | None = None,
    ):
        own = own or JointState((), ())
        self._name, self._joints = name, (*own.names, *JOINTS)
        start = JointState(self._joints, [*own.position, *_joints_of(home or Pose([0.3, -0.4, 0.5]))])
        self._states = {"home": start, **(states or {})}
        self._taught = taught if taught is not None else TaughtStates()
        scripts = dict(script or {})
        schedule = schedule or AtOnce()
        self._gantry = FakeExecutor(start, schedule, scripts.pop("execute", ()))
        self._executor = PausableExecutor(self._gantry, now=schedule.now)
        self._stream = SteeredMotion(self._executor, self._plan_step)
        self._scripts = {verb: steps_of(scripts.pop(verb, ())) for verb in PLANNING}
        if scripts:
            raise UnknownNameError("verb of a fake arm", next(iter(scripts)), (*self._scripts, "execute"))

    @property
    def name(self) -> str:
        """The arm's name in the project."""
        return self._name

    def state(self) -> JointState:
        """Return where its joints are."""
        return self._executor.state()

    def grasp_pose(self) -> Pose:
        """Return where the grasp frame is in world."""
        return _pose_of(self.state().position)

    def named_states(self) -> Mapping[str, JointState]:
        """Return its named states."""
        return {**self._taught.states(self._name), **self._states}

    def plan(
        self,
        goal: JointState | Pose | str,
        *,
        start: JointState | None = None,
        free: str = "none",
        constraint: PathConstraint | None = None,
    ) -> Operation[Plan]:
        """Plan a straight motion of the joints; only its ends are held to the constraint. See `ports.Arm`."""
        if free not in FREEDOMS:
            raise UnknownNameError("freedom of a pose", free, FREEDOMS, where=f"arm {self._name!r}")
        begin = self._row(self.state().position, start)
        end = self._end(goal, begin)
        broken = _broken(constraint, {"start": begin, "goal": end})
        return self._planned("plan", [end], begin) if broken is None else Operation.failed(broken)

    def plan_straight(self, goals: Sequence[Pose], *, start: JointState | None = None) -> Operation[Plan]:
        """Plan a motion through poses; see `ports.Arm`."""
        begin = self._row(self.state().position, start)
        return self._planned("plan_straight", [self._end(goal, begin) for goal in goals], begin)

    def plan_through(
        self,
        way_points: Sequence[WayPoint],
        *,
        start: JointState | None = None,
        constraint: PathConstraint | None = None,
    ) -> Operation[Plan]:
        """Plan a motion that goes through the points themselves, and only there keeps to the constraint.

        Fakes round no corners. See `ports.Arm`.
        """
        if not way_points:
            raise ValueError("at least one way point is needed")
        rows = [self._row(self.state().position, start)]
        for point in way_points:
            rows.append(self._end(point.goal, rows[-1]))
        begin, *ends = rows
        named = {"start": begin, **{f"way point {k}": end for k, end in enumerate(ends, 1)}}
        if (broken := _broken(constraint, named)) is not None:
            return Operation.failed(broken)
        none = (0.0,) * (len(ends) - 1)
        planned = self._planned("plan_through", ends, begin)
        return planned.then(lambda plan: Operation.finished(replace(plan, radii=none)))

    def plan_from_trajectory(self, trajectory: Trajectory, *, slow_down: bool = False) -> Operation[Plan]:
        """Make a plan of a trajectory; fakes know no limits and no shapes. See `ports.Arm`."""
        require_joints(trajectory.names, self._joints, self._name)
        failure = next(self._scripts["plan_from_trajectory"])
        if failure is not None:
            return Operation.failed(failure)
        rows = np.tile(self.state().position, (len(trajectory.times), 1))
        rows[:, [self._joints.index(name) for name in trajectory.names]] = trajectory.positions
        return Operation.finished(Plan("gantry", Trajectory(self._joints, trajectory.times, rows), "given"))

    def check_together(self, plans: Sequence[Plan]) -> Operation[None]:
        """Find nothing in the way: fakes know no shapes."""
        return Operation.finished(None)

    def jog(
        self, linear: Sequence[float], angular: Sequence[float] = (0.0, 0.0, 0.0), seconds: float = 0.5
    ) -> Operation[JointState]:
        """Move with a bounded twist for a while; see `ports.Arm`."""
        goal, seconds = jogged(self.grasp_pose(), linear, angular, seconds)
        return self.plan_straight([goal]).then(lambda plan: self.execute(lasting(plan, seconds)))

    def steer(self, linear: Sequence[float], angular: Sequence[float] = (0.0, 0.0, 0.0)) -> Operation[JointState]:
        """Move with a twist from now on; see `ports.Arm`."""
        bounded(linear, angular)
        return self._stream.steer(lambda _: (linear, angular))

    def steer_to(self, target: Pose, speed: float = 0.15) -> Operation[JointState]:
        """Steer towards a pose; see `ports.Arm`."""
        return self._stream.steer(lambda there: approaching(_pose_of(there.position), target, speed, HOLD))

    def teach(self, name: str, *, pose: bool = False) -> JointState | Pose:
        """Remember where it is now, for this run; see `ports.Arm`."""
        value = self.grasp_pose() if pose else JointState(self._joints, self.state().position)
        self._taught.put(self._name, name, value, self._states)
        return value

    def taught(self) -> Mapping[str, JointState | Pose]:
        """Return what was taught; see `ports.Arm`."""
        return self._taught.of(self._name)

    def execute(self, plan: Plan) -> Operation[JointState]:
        """Execute a plan; the result is where the joints are at the end."""
        return self._executor.execute(plan.trajectory)

    def put_back(self, position: Array) -> None:
        """Have the joints where they were, when nothing is under way.

        Args:
            position: of the robot's own joints, then of `JOINTS`.

        Raises:
            ValueError: it has another shape.
        """
        self._gantry.put_back(position)

    def choose_grasp(self, grasps: Sequence[Grasp]) -> Operation[Grasp]:
        """Return the grasp of the highest quality."""
        failure: ExpectedError | None = next(self._scripts["choose_grasp"])
        if failure is None and not grasps:
            failure = NoGraspError("none of 0 grasps is feasible", reasons={}, candidates=0)
        if failure is not None:
            return Operation.failed(failure)
        return Operation.finished(max(grasps, key=lambda g: g.quality))

    def stop(self) -> None:
        """Come to rest, and end a motion under way."""
        self._executor.stop()

    def pause(self) -> None:
        """Hold in the middle of a motion; see `ports.Pausable`."""
        self._executor.pause()

    def resume(self) -> None:
        """Go on with it."""
        self._executor.resume()

    def _plan_step(self, start: JointState, twist: Twist, hold: float) -> Operation[Trajectory]:
        failure = next(self._scripts["plan_step"])
        if failure is not None:
            return Operation.failed(failure)

        def wanted(q: Array) -> Array:
            rates = (_joints_of(jogged(_pose_of(q), *twist, _MOMENT)[0]) - q[-len(JOINTS) :]) / _MOMENT
            still = np.zeros(len(q) - len(rates))
            return np.concatenate([still, rates / max(1.0, float(np.abs(rates).max()) / SPEED)])

        limits = np.full(len(self._joints), ACCELERATION)
        step = steered(self._joints, start.position, velocity_of(start, self._joints), wanted, limits, hold)
        return Operation.finished(step)

    def _end(self, goal: JointState | Pose | str, begin: Array) -> Array:
        if isinstance(goal, str):
            states = self.named_states()
            if goal not in states:
                raise UnknownNameError("named state", goal, states, where=f"arm {self._name!r}")
            goal = states[goal]
        return self._row(begin, JointState(JOINTS, _joints_of(goal)) if isinstance(goal, Pose) else goal)

    def _row(self, begin: Array, state: JointState | None) -> Array:
        """Return the positions of all joints, shape (n,); those that aren't named are where they were."""
        row, named = np.array(begin), {} if state is None else state.as_mapping()
        require_joints(tuple(named), self._joints, self._name)
        row[[self._joints.index(name) for name in named]] = list(named.values())
        return row

    def _planned(self, verb: str, ends: Sequence[Array], begin: Array) -> Operation[Plan]:
        failure = next(self._scripts[verb])
        if failure is not None:
            return Operation.failed(failure)
        rows, times = [begin], [0.0]
        for end in ends:
            span = float(np.abs(end - rows[-1]).max())
            if span > 0:
                times.append(times[-1] + span / SPEED)
                rows.append(end)
        return Operation.finished(Plan("gantry", Trajectory(self._joints, np.array(times), np.stack(rows)), "fake"))


def _joints_of(pose: Pose) -> Array:
    """Return position and rotation vector, shape (6,); the vector's length is the angle, at most pi [rad]."""
    return np.concatenate([pose.position, pose.rotation_vector()])


def _pose_of(joints: Array) -> Pose:
    *_, x, y, z, a, b, c = joints
    vector = np.array([a, b, c])
    angle = float(np.linalg.norm(vector))
    axis = vector / angle if angle > 1e-12 else np.zeros(3)
    return Pose((x, y, z), np.concatenate([[np.cos(angle / 2)], axis * np.sin(angle / 2)]))


def _broken(constraint: PathConstraint | None, rows: Mapping[str, Array]) -> ConstraintBrokenError | None:
    """Return the error for the first of some named rows of joints that breaks a constraint, or None."""
    for what, joints in rows.items():
        if constraint is not None and not constraint.kept_by(_pose_of(joints)):
            return ConstraintBrokenError(f"the {what} violates the path constraint; widen its tolerances or its box")
    return None
