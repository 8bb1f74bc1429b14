"""Every Protocol between rooms. Adapters (fake, simulation, ROS 2) implement them; `grip_bt.app` picks the adapters.

Whatever takes time returns an `Operation`. Motions end with what was *measured*, never with what was sent. Expected
trouble ends an operation with an `ExpectedError`, whose code becomes the failure reason of the leaf.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from .operation import Operation
from .values import CameraInfo, Grasp, JointState, Plan, Pose, RgbdFrame, Trajectory
from .values.solids import Mesh, Solid

T = TypeVar("T")
FREEDOMS = ("none", "x", "y", "z", "orientation")
"""What of a goal pose may not matter: nothing, a turn about an axis of the grasp frame, or the whole orientation."""


@runtime_checkable
class Clock(Protocol):
    """The one clock of a run: wall, simulator, ROS or manual."""

    def now(self) -> float:
        """Return the time [s]; it never decreases."""
        ...


@runtime_checkable
class Pausable(Protocol):
    """A clock, or a part of a robot, that can stand still in the middle of what it does and go on afterwards."""

    def pause(self) -> None:
        """Hold what moves where it is and keep what is left of it; harmless when it is paused."""
        ...

    def resume(self) -> None:
        """Go on with what is left; harmless when it isn't paused."""
        ...


@runtime_checkable
class Executor(Protocol):
    """Moves the joints of one group along a trajectory."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints that it moves, in its order."""
        ...

    def state(self) -> JointState:
        """Return the measured state of the joints."""
        ...

    def execute(self, trajectory: Trajectory) -> Operation[JointState]:
        """Follow a trajectory that starts at the present positions; the result is the measured state at the end.

        Ends with ExecutionAbortedError when the start or the end is off by more than the adapter's tolerance, with
        CanceledError when it was stopped; the joints then hold where they are.
        """
        ...

    def stop(self) -> None:
        """Hold where the joints are now and end a motion under way."""
        ...


@runtime_checkable
class HandPort(Protocol):
    """Moves the fingers of one hand."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints of the hand."""
        ...

    def state(self) -> JointState:
        """Return the measured state, with efforts [N m] where they are known."""
        ...

    def move(self, posture: JointState, duration: float, torque_limit: float | None = None) -> Operation[JointState]:
        """Move the fingers towards a posture during `duration` [s] with at most `torque_limit` [N m].

        The result is the measured state when the time is over or all fingers have stopped moving, also when contact
        kept them from the posture.
        """
        ...

    def contacts(self) -> Mapping[str, float]:
        """Return the contact force [N] of each link of the hand that touches something that isn't the robot."""
        ...

    def stop(self) -> None:
        """Hold the fingers where they are."""
        ...


@runtime_checkable
class Camera(Protocol):
    """An RGB-D camera."""

    def info(self) -> CameraInfo:
        """Return the camera's geometry."""
        ...

    def capture(self) -> Operation[RgbdFrame]:
        """Take one frame. Ends with SensorError when there is none."""
        ...


@runtime_checkable
class Scene(Protocol):
    """What the planner avoids. Each change is seen by the next plan."""

    def set_box(self, name: str, size: Sequence[float], pose: Pose) -> None:
        """Add or replace a box of `size` (3 edge lengths [m]), centred at `pose` in world."""
        ...

    def put(self, name: str, solid: Solid, pose: Pose) -> None:
        """Add or replace an object of any shape, whose own axes are at `pose` in world."""
        ...

    def solid(self, name: str) -> tuple[Solid, Pose]:
        """Return an object's shape and its present pose in world, attached or not.

        Raises:
            UnknownNameError: it isn't there.
        """
        ...

    def load(self, file: str) -> tuple[str, ...]:
        """Add the objects of a `.scene` file, a path in the project, and return their names.

        Raises:
            DocumentError: it can't be read, or isn't one.
        """
        ...

    def mesh(self, file: str, scale: Sequence[float] = (1.0, 1.0, 1.0), hollow: bool = False) -> Mesh:
        """Read a mesh file, a path in the project or `package://...`: its convex hull, or its hollow surface.

        Raises:
            DocumentError: it can't be read, or isn't one.
            UnknownNameError: the package isn't known.
        """
        ...

    def fixed(self, name: str) -> bool:
        """Tell whether an object belongs to the room, so that it can't be removed, replaced or attached."""
        ...

    def allow(self, one: str, other: str, allowed: bool = True) -> None:
        """Allow contact between two names, or forbid it again.

        A name is an object's, a link's, a hand's or an arm's, which stands for all its links, or `*` for everything.

        Raises:
            UnknownNameError: it is none of these.
        """
        ...

    def snapshot(self) -> Any:
        """Return the present state as a value that `restore` takes."""
        ...

    def restore(self, snapshot: Any) -> None:
        """Go back to an earlier state: objects, what hands hold, and allowed collisions."""
        ...

    def remove(self, name: str) -> None:
        """Remove an object; nothing happens when it isn't there."""
        ...

    def names(self) -> tuple[str, ...]:
        """Return the names of all objects."""
        ...

    def box(self, name: str) -> tuple[NDArray[np.float64], Pose]:
        """Return an object's edge lengths, shape (3,) [m], and its present pose in world, attached or not.

        Raises:
            UnknownNameError: it isn't there.
        """
        ...

    def attached(self, hand: str) -> tuple[str, ...]:
        """Return the names of the objects that move with the hand."""
        ...

    def attach(self, name: str, hand: str) -> None:
        """From now on the object moves with the hand and may touch it."""
        ...

    def detach(self, name: str) -> None:
        """The object stays where it is now; nothing happens when it isn't attached."""
        ...


@runtime_checkable
class Arm(Protocol):
    """What leaves ask of an arm. Plans avoid the scene; straight motions are checked against it too."""

    @property
    def name(self) -> str:
        """The arm's name in the project."""
        ...

    def state(self) -> JointState:
        """Return the measured state of the arm's joints."""
        ...

    def grasp_pose(self) -> Pose:
        """Return the measured pose of the hand's grasp frame in world."""
        ...

    def named_states(self) -> Mapping[str, JointState]:
        """Return the arm's named states, such as `home`."""
        ...

    def plan(
        self, goal: JointState | Pose | str, *, start: JointState | None = None, free: str = "none"
    ) -> Operation[Plan]:
        """Plan to joint positions, to a pose of the grasp frame, or to a named state.

        Args:
            goal: where to.
            start: joint positions to begin from; the measured ones by default.
            free: what of a pose doesn't matter: `none`, a turn about the grasp frame's `x`, `y` or `z`, or its whole
                `orientation`.

        Ends with StartInCollisionError, GoalInCollisionError, NoIkError, NoPlanError, PathInvalidError or TimeOutError.

        Raises:
            UnknownNameError: there is no such named state, or no such freedom.
        """
        ...

    def plan_straight(self, goals: Sequence[Pose], *, start: JointState | None = None) -> Operation[Plan]:
        """Plan a motion that moves the grasp frame along straight lines through `goals`.

        Ends with NoIkError, PathInvalidError (collision or joint jump).
        """
        ...

    def jog(
        self, linear: Sequence[float], angular: Sequence[float] = (0.0, 0.0, 0.0), seconds: float = 0.5
    ) -> Operation[JointState]:
        """Move the grasp frame with a twist for a while; too large a one is made smaller, in the same direction.

        Args:
            linear: velocity of its origin in world, 3 numbers [m/s].
            angular: angular velocity in world, 3 numbers [rad/s].
            seconds: for how long.

        Ends with NoIkError, PathInvalidError or ExecutionAbortedError; where it can't go, it doesn't begin to.

        Raises:
            ValueError: a number isn't finite, or the time isn't positive.
        """
        ...

    def teach(self, name: str, *, pose: bool = False) -> JointState | Pose:
        """Remember where the arm is now, as a named state or as a pose of the grasp frame, and return it.

        Raises:
            NameTakenError: the robot's description has a state of this name.
            ValueError: the name isn't a word.
        """
        ...

    def taught(self) -> Mapping[str, JointState | Pose]:
        """Return what was taught: name -> state or pose. The states are named states too."""
        ...

    def execute(self, plan: Plan) -> Operation[JointState]:
        """Execute a plan; the result is what was measured at the end."""
        ...

    def choose_grasp(self, grasps: Sequence[Grasp]) -> Operation[Grasp]:
        """Return the first grasp, by falling quality, whose approach, closing and lift are reachable and free.

        Ends with NoGraspError, whose `data['reasons']` counts why candidates were refused.
        """
        ...

    def stop(self) -> None:
        """Hold where the arm is now and end a motion under way."""
        ...


@runtime_checkable
class Hand(Protocol):
    """What leaves ask of a hand."""

    @property
    def name(self) -> str:
        """The hand's name in the project."""
        ...

    def state(self) -> JointState:
        """Return the measured state of the hand's joints."""
        ...

    def named_states(self) -> Mapping[str, JointState]:
        """Return the hand's named postures; `open` and `closed` are among them."""
        ...

    def fingers(self) -> Mapping[str, tuple[str, ...]]:
        """Return the hand's fingers: name -> joints."""
        ...

    def contacts(self) -> Mapping[str, float]:
        """Return the contact force [N] of each link of the hand that touches something."""
        ...

    def open(self, posture: JointState | str = "open") -> Operation[JointState]:
        """Open to a posture, given or named."""
        ...

    def move(
        self, posture: JointState | str, torque_limit: float | None = None, seconds: float | None = None
    ) -> Operation[JointState]:
        """Move the fingers towards a posture, touching or not; joints that it doesn't name stay where they are.

        Raises:
            UnknownNameError: there is no such posture or joint.
            ValueError: the torque limit [N m] or the time isn't positive.
        """
        ...

    def finger_posture(self, closing: Mapping[str, float]) -> JointState:
        """Return the posture of some fingers: finger -> how far it is closed, 0 (as in `open`) to 1 (as in `closed`).

        Raises:
            UnknownNameError: there is no such finger.
            ValueError: a number isn't in [0, 1].
        """
        ...

    def synergy(self, weights: Sequence[float]) -> JointState:
        """Return the posture of weights of the hand's synergies, kept within the joints' limits.

        Raises:
            ValueError: there are more weights than synergies, or one isn't finite.
        """
        ...

    def teach(self, name: str) -> JointState:
        """Remember the fingers' present posture as a named one, and return it; see `Arm.teach`."""
        ...

    def close(self, posture: JointState | str = "closed", torque_limit: float | None = None) -> Operation[JointState]:
        """Close towards a posture until the fingers stop. Ends with NoContactError when nothing was touched."""
        ...

    def stop(self) -> None:
        """Hold the fingers where they are."""
        ...


@runtime_checkable
class Component(Protocol):
    """An external component: somebody's service or action, reached by its contract."""

    def call(self, request: Mapping[str, Any]) -> Operation[Mapping[str, Any]]:
        """Send the request's fields; the result holds the response's fields, converted to GRIP's values.

        Ends with ServerLostError, ServerTimeOutError or BadReplyError.
        """
        ...


@runtime_checkable
class Sensor(Protocol):
    """A sensor that gives one or several values of one moment."""

    def capture(self) -> Operation[Mapping[str, Any]]:
        """Take one value of each output, by name. Ends with SensorError or ServerTimeOutError."""
        ...


@runtime_checkable
class Ros(Protocol):
    """What leaves ask of ROS directly: topics, frames and parameters, by name; message types as ROS spells them."""

    def listen(self, topic: str, message: str) -> None:
        """Subscribe now, so that a later `recent` finds what came since."""
        ...

    def next(self, topic: str, message: str, value: str, timeout: float) -> Operation[Any]:
        """Wait for the next message and return it as the declared type `value`. Ends with ServerTimeOutError."""
        ...

    def recent(self, topic: str, message: str, value: str, max_age: float, timeout: float) -> Operation[Any]:
        """Return the last message when it is at most `max_age` [s] old, else the next."""
        ...

    def together(self, topics: Mapping[str, str], slop: float, timeout: float) -> Operation[Mapping[str, Any]]:
        """Wait for a message of each topic (topic -> type), stamped at most `slop` [s] apart; by topic."""
        ...

    def publish(self, topic: str, message: str, value: Any, subscribers: int, timeout: float) -> Operation[None]:
        """Publish a value when at least `subscribers` listen."""
        ...

    def transform(self, target: str, source: str, timeout: float) -> Operation[Pose]:
        """Return the pose of frame `source` in frame `target`. Ends with an error of code `no_frame`."""
        ...

    def get_parameter(self, node: str, name: str, timeout: float) -> Operation[Any]:
        """Return a parameter of a node. Ends with ServerLostError, or BadReplyError when it isn't set."""
        ...

    def set_parameter(self, node: str, name: str, value: Any, timeout: float) -> Operation[None]:
        """Set a parameter of a node. Ends with ServerLostError, or BadReplyError with the node's reason."""
        ...


@runtime_checkable
class Messages(Protocol):
    """Named values that outlive a task: stores of joint states, poses, grasps, anything."""

    def put(self, store: str, name: str, value: Any, provenance: str = "") -> Operation[None]:
        """Add or replace a value; without a name it goes to the end of the store's queue.

        Raises:
            WrongTypeError: the store holds another type.
        """
        ...

    def get(self, store: str, name: str) -> Operation[Any]:
        """Return an entry, with `value`, `time` [s of the Unix epoch] and `provenance`.

        Without a name: the oldest of the store's queue, which is removed. Ends with NoEntryError or EmptyQueueError.
        """
        ...

    def names(self, store: str) -> Operation[tuple[str, ...]]:
        """Return the names in a store. Ends with NoEntryError."""
        ...

    def delete(self, store: str, name: str) -> Operation[None]:
        """Remove an entry. Ends with NoEntryError."""
        ...

    def reset(self, store: str = "") -> Operation[None]:
        """Empty a store, or all, and read the project's files again. Ends with NoEntryError."""
        ...

    def save(self) -> Operation[int]:
        """Keep everything for later runs; the result is the number of entries."""
        ...


class Context(Protocol):
    """What a run offers to its leaves."""

    @property
    def clock(self) -> Clock:
        """The run's clock."""
        ...

    @property
    def preempt_requested(self) -> bool:
        """Whether somebody asked the task to come to an end on its own terms."""
        ...

    def wake(self) -> None:
        """Have the task ticked soon; from any thread."""
        ...

    def wake_at(self, time: float) -> None:
        """Have the task ticked when the run's clock reaches `time` [s]."""
        ...

    def run_in_worker(self, work: Callable[[], T]) -> Operation[T]:
        """Run blocking code in a worker thread."""
        ...

    def arm(self, name: str) -> Arm:
        """Return an arm; UnknownNameError lists those that exist. An empty name means the only one."""
        ...

    def hand(self, name: str) -> Hand:
        """Return a hand, likewise."""
        ...

    def camera(self, name: str) -> Camera:
        """Return a sensor's camera, likewise."""
        ...

    def component(self, name: str) -> Component:
        """Return an external component, likewise."""
        ...

    def scene(self) -> Scene:
        """Return the planning scene."""
        ...

    def sensor(self, name: str) -> Sensor:
        """Return a sensor that gives what topics carry; UnknownNameError lists those that exist."""
        ...

    def ros(self) -> Ros:
        """Return the connection to ROS; MissingPartError when this run has none."""
        ...

    def messages(self) -> Messages:
        """Return the project's named values; MissingPartError when this run has none."""
        ...


__all__ = [
    "FREEDOMS",
    "Arm",
    "Camera",
    "Clock",
    "Component",
    "Context",
    "Executor",
    "Hand",
    "HandPort",
    "Messages",
    "Ros",
    "Scene",
    "Sensor",
]
