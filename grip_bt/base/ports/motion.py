"""What moves joints, and arms as leaves ask for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple, Protocol, get_args, runtime_checkable

from grip_bt.base.arrays import Array
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState, Plan, Pose, Trajectory
from grip_bt.base.values.goals import Grasp, PathConstraint, WayPoint

Free = Literal["none", "x", "y", "z", "orientation"]
FREEDOMS: tuple[Free, ...] = get_args(Free)
"""What of a goal pose may not matter: nothing, a turn about an axis of the grasp frame, or the whole orientation."""


@runtime_checkable
class Executor(Protocol):
    """Moves the joints of one group along a trajectory."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints that it moves, in its order."""

    def state(self) -> JointState:
        """Return the measured state of the joints."""

    def execute(self, trajectory: Trajectory) -> Operation[JointState]:
        """Follow a trajectory that starts at the present positions; the result is the measured state at the end.

        Ends with ExecutionAbortedError when the start or the end is off by more than the adapter's tolerance, with
        CanceledError when it was stopped; the joints then hold where they are.
        """

    def stop(self) -> None:
        """Hold where the joints are now and end a motion under way."""


@runtime_checkable
class Steerable(Protocol):
    """An executor of which a motion can be changed while it is under way."""

    @property
    def steerable(self) -> bool:
        """Whether it can; what hands on to others tells it of those."""

    def execute_steered(self, trajectory: Trajectory) -> Operation[JointState]:
        """Begin a motion that can be changed by `amend`; else as `Executor.execute`."""

    def passed(self) -> float | None:
        """Return for how long the steered motion under way has been followed [s]; None when there is none."""

    def amend(self, tail: Trajectory, at: float) -> bool:
        """Go on with `tail` from `at` seconds after the beginning of the steered motion under way.

        The operation of the motion ends when the tail does. Returns False, and changes nothing, when that moment is
        over or nothing moves.

        Raises:
            ValueError: the tail moves other joints, or begins elsewhere than the motion is at that moment.
        """


class Ways(NamedTuple):
    """What an arm does and is about to do, for drawing it."""

    follows: Trajectory | None = None
    """The motion that it was told to follow last."""
    moving: bool = False
    """Whether it follows that still."""
    planned: tuple[Trajectory, ...] = ()
    """Motions that were planned and not begun, of each series of plans the next one first."""


@runtime_checkable
class Arm(Protocol):
    """What leaves ask of an arm. Plans avoid the scene; straight motions are checked against it too."""

    @property
    def name(self) -> str:
        """The arm's name in the project."""

    @property
    def ways(self) -> Ways:
        """What it follows and has planned."""

    def state(self) -> JointState:
        """Return the measured state of the arm's joints."""

    def grasp_pose(self) -> Pose:
        """Return the measured pose of the hand's grasp frame in world."""

    def wrench(self) -> Array:
        """Return what a sensor at the wrist bears from outside: force [N], torque [N m], in world's axes, shape (6,).

        The torque is about the sensor's origin.

        Raises:
            SensorError: there is no such sensor, or nothing was heard of it.
        """

    def named_states(self) -> Mapping[str, JointState]:
        """Return the arm's named states, such as `home`."""

    def plan(
        self,
        goal: JointState | Pose | str,
        *,
        start: JointState | None = None,
        free: str = "none",
        constraint: PathConstraint | None = None,
    ) -> Operation[Plan]:
        """Plan to joint positions, to a pose of the grasp frame, or to a named state.

        Args:
            start: joint positions to begin from; the measured ones by default.
            free: part of a pose that is free: `none`, the turn about the grasp frame's `x`, `y` or `z`, or the whole
                `orientation`.
            constraint: what the grasp frame keeps to on the whole way, both ends included.

        Ends with StartInCollisionError, GoalInCollisionError, NoIkError, NoPlanError, PathInvalidError, TimeOutError or
        ConstraintBrokenError.

        Raises:
            UnknownNameError: there is no such named state, or no such freedom.
        """

    def plan_straight(self, goals: Sequence[Pose], *, start: JointState | None = None) -> Operation[Plan]:
        """Plan a motion that moves the grasp frame along straight lines through `goals`.

        Ends with NoIkError, PathInvalidError (collision or joint jump).
        """

    def plan_through(
        self,
        way_points: Sequence[WayPoint],
        *,
        start: JointState | None = None,
        constraint: PathConstraint | None = None,
    ) -> Operation[Plan]:
        """Plan one motion through way points, without a stop at inner ones that have a blend radius.

        A radius that doesn't fit is made smaller: a blend takes at most half of a segment, and one whose corner would
        touch something is tried with a half, a quarter and an eighth of its radius; then the arm comes to rest at the
        point. `radii` of the plan tells what they became.

        Args:
            way_points: one or more; see `values.WayPoint`.
            start: joint positions to begin from; the measured ones by default.
            constraint: what the grasp frame keeps to on the whole way, corners included.

        Ends as `plan` and `plan_straight` do.

        Raises:
            UnknownNameError: there is no such named state.
            ValueError: there are no way points.
        """

    def plan_from_trajectory(self, trajectory: Trajectory, *, slow_down: bool = False) -> Operation[Plan]:
        """Check a trajectory that was made elsewhere, such as a stored one, and make a plan of it, as it is.

        Points without velocities get those of the monotone cubic through them.

        Args:
            trajectory: of some or all of the arm's joints; the others stay where they are. It may begin elsewhere than
                the arm is.
            slow_down: whether it is made longer as a whole where it is faster than other plans of the arm.

        Ends with OutOfLimitsError (positions, velocities, accelerations) or PathInvalidError (collision).

        Raises:
            UnknownNameError: it names a joint that isn't the arm's.
        """

    def check_together(self, plans: Sequence[Plan]) -> Operation[None]:
        """Check that plans of several arms, begun at once and followed as their times say, keep the arms apart.

        Ends with PathInvalidError where something would be touched.
        """

    def jog(
        self, linear: Sequence[float], angular: Sequence[float] = (0.0, 0.0, 0.0), seconds: float = 0.5
    ) -> Operation[JointState]:
        """Move the grasp frame with a twist for a while; too large a one is made smaller, in the same direction.

        Args:
            linear: velocity of its origin in world, 3 numbers [m/s].
            angular: angular velocity in world, 3 numbers [rad/s].

        Ends with NoIkError, PathInvalidError or ExecutionAbortedError; where it can't go, it doesn't begin to.

        Raises:
            ValueError: a number isn't finite, or the time isn't positive.
        """

    def steer(self, linear: Sequence[float], angular: Sequence[float] = (0.0, 0.0, 0.0)) -> Operation[JointState]:
        """Move the grasp frame with a twist from now on, without a stop where the executor is steerable.

        To be called again every 0.1 s or so: what is asked takes its effect 0.2 s later at most, and the arm comes to
        rest when nothing more is asked. Each step is known to be free to its end, at rest, before it begins; where it
        isn't, the arm comes to rest before it.

        Args:
            linear: velocity of its origin in world, 3 numbers [m/s]; too large a twist is made smaller.
            angular: angular velocity in world, 3 numbers [rad/s].

        Returns:
            The motion from rest to rest, the same operation as long as it goes on.

        Ends with NoIkError, OutOfLimitsError, PathInvalidError or ExecutionAbortedError, the arm being at rest.

        Raises:
            ValueError: a number isn't finite.
        """

    def steer_to(self, target: Pose, speed: float = 0.15) -> Operation[JointState]:
        """Steer the grasp frame towards a pose in world, slower near it; see `steer`.

        Args:
            speed: of the grasp frame's origin at most [m/s].
        """

    def teach(self, name: str, *, pose: bool = False) -> JointState | Pose:
        """Remember where the arm is now, as a named state or as a pose of the grasp frame, and return it.

        Raises:
            NameTakenError: the robot's description has a state of this name.
            ValueError: the name isn't a word.
        """

    def taught(self) -> Mapping[str, JointState | Pose]:
        """Return what was taught: name -> state or pose. The states are named states too."""

    def execute(self, plan: Plan) -> Operation[JointState]:
        """Execute a plan; the result is what was measured at the end."""

    def choose_grasp(self, grasps: Sequence[Grasp]) -> Operation[Grasp]:
        """Return the first grasp, by falling quality, whose approach, closing and lift are reachable and free.

        Ends with NoGraspError, whose `data['reasons']` counts why candidates were refused.
        """

    def stop(self) -> None:
        """Hold where the arm is now and end a motion under way."""
