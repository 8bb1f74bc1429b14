"""What a robot avoids and sees, and what else it is among: components, ROS itself, values that outlive a task."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, runtime_checkable

from grip_bt.base.arrays import Array
from grip_bt.base.operation import Operation
from grip_bt.base.values import CameraInfo, JointState, Pose, RgbdFrame
from grip_bt.base.values.solids import Mesh, Solid


@runtime_checkable
class Scene(Protocol):
    """What the planner avoids. Each change is seen by the next plan."""

    def set_box(self, name: str, size: Sequence[float], pose: Pose) -> None:
        """Add or replace a box of `size` (3 edge lengths [m]), centred at `pose` in world."""

    def put(self, name: str, solid: Solid, pose: Pose) -> None:
        """Add or replace an object of any shape, whose own axes are at `pose` in world."""

    def solid(self, name: str) -> tuple[Solid, Pose]:
        """Return an object's shape and its present pose in world, attached or not.

        Raises:
            UnknownNameError: it isn't there.
        """

    def regions(self) -> Mapping[str, tuple[Sequence[float], Pose]]:
        """Return places to aim at, which nothing need bound: name -> edge lengths [m], and the middle in world."""

    def load(self, file: str) -> tuple[str, ...]:
        """Add the objects of a `.scene` file, a path in the project, and return their names.

        Raises:
            DocumentError: it can't be read, or isn't one.
        """

    def mesh(self, file: str, scale: Sequence[float] = (1.0, 1.0, 1.0), hollow: bool = False) -> Mesh:
        """Read a mesh file, a path in the project or `package://...`: its convex hull, or its hollow surface.

        Raises:
            DocumentError: it can't be read, isn't one, or its package isn't known.
        """

    def fixed(self, name: str) -> bool:
        """Tell whether an object belongs to the room, so that it can't be removed, replaced or attached."""

    def allow(self, one: str, other: str, allowed: bool = True) -> None:
        """Allow contact between two names, or forbid it again.

        A name is an object's, a link's, a hand's or an arm's, which stands for all its links, or `*` for everything.

        Raises:
            UnknownNameError: it is none of these.
        """

    def snapshot(self) -> object:
        """Return the present state as a value that `restore` takes."""

    def restore(self, snapshot: object) -> None:
        """Go back to an earlier state: objects, what hands hold, and allowed collisions."""

    def remove(self, name: str) -> None:
        """Remove an object; nothing happens when it isn't there."""

    def names(self) -> tuple[str, ...]:
        """Return the names of all objects."""

    def box(self, name: str) -> tuple[Array, Pose]:
        """Return an object's edge lengths, shape (3,) [m], and its present pose in world, attached or not.

        Raises:
            UnknownNameError: it isn't there.
        """

    def robot(self, at: JointState | None = None) -> Sequence[Array]:
        """Return the robot's shapes, each as points, shape (k, 3) in world [m], whose convex hull contains it.

        Its joints are where they are measured, but for those in `at`. Nothing where its geometry isn't known.
        """

    def attached(self, hand: str) -> tuple[str, ...]:
        """Return the names of the objects that move with the hand."""

    def attach(self, name: str, hand: str) -> None:
        """From now on the object moves with the hand and may touch it."""

    def detach(self, name: str) -> None:
        """The object stays where it is now; nothing happens when it isn't attached."""


@runtime_checkable
class Camera(Protocol):
    """An RGB-D camera."""

    def info(self) -> CameraInfo:
        """Return the camera's geometry. Raises SensorError: it isn't known before the first frame."""

    def capture(self) -> Operation[RgbdFrame]:
        """Take one frame. Ends with SensorError when there is none."""


@runtime_checkable
class Sensor(Protocol):
    """A sensor that gives one or several values of one moment."""

    def capture(self) -> Operation[Mapping[str, object]]:
        """Take one value of each output, by name. Ends with SensorError or ServerTimeOutError."""


@runtime_checkable
class Component(Protocol):
    """An external component: somebody's service or action, reached by its contract."""

    def call(self, request: Mapping[str, object]) -> Operation[Mapping[str, object]]:
        """Send the request's fields; the result holds the response's fields, converted to GRIP's values.

        Ends with ServerLostError, ServerTimeOutError or BadReplyError.
        """


@runtime_checkable
class Ros(Protocol):
    """What leaves ask of ROS directly: topics, frames and parameters, by name; message types as ROS spells them."""

    def check(self, name: str, message: str = "") -> None:
        """Check a name of the graph, and a message type that is going to be used, before anything moves.

        Raises:
            GripError: it can't be one; there is no such message, or its package isn't available.
        """

    def listen(self, topic: str, message: str) -> None:
        """Subscribe now, so that a later `recent` finds what came since."""

    def next(self, topic: str, message: str, value: str, timeout: float) -> Operation[object]:
        """Wait for the next message and return it as the declared type `value`. Ends with ServerTimeOutError.

        Args:
            topic: its full name.
            message: its ROS type; empty for what it is published as.
            value: what becomes of it; `Any` leaves it as it is.
            timeout: how long to wait [s]; infinite for as long as it takes.
        """

    def recent(self, topic: str, message: str, value: str, max_age: float, timeout: float) -> Operation[object]:
        """Return the last message when it is at most `max_age` [s] old, else the next."""

    def together(self, topics: Mapping[str, str], slop: float, timeout: float) -> Operation[Mapping[str, Any]]:
        """Wait for a message of each topic (topic -> type), stamped at most `slop` [s] apart; by topic."""

    def publish(self, topic: str, message: str, value: object, subscribers: int, timeout: float) -> Operation[None]:
        """Publish a value when at least `subscribers` listen."""

    def transform(self, target: str, source: str, timeout: float, at: float | None = None) -> Operation[Pose]:
        """Return the pose of frame `source` in frame `target`, as it is or as it was at a time [s].

        Ends with an error of code `no_frame`.
        """

    def get_parameter(self, node: str, name: str, timeout: float) -> Operation[object]:
        """Return a parameter of a node. Ends with ServerLostError, or BadReplyError when it isn't set."""

    def set_parameter(self, node: str, name: str, value: object, timeout: float) -> Operation[None]:
        """Set a parameter of a node. Ends with ServerLostError, or BadReplyError with the node's reason."""


@runtime_checkable
class Messages(Protocol):
    """Named values that outlive a task: stores of joint states, poses, grasps, anything."""

    def put(self, store: str, name: str, value: object, provenance: str = "") -> Operation[None]:
        """Add or replace a value; without a name it goes to the end of the store's queue.

        Raises:
            WrongTypeError: the store holds another type.
        """

    def get(self, store: str, name: str) -> Operation[Any]:
        """Return an entry, with `value`, `time` [s of the Unix epoch] and `provenance`.

        Without a name: the oldest of the store's queue, which is removed. Ends with NoEntryError or EmptyQueueError.
        """

    def names(self, store: str) -> Operation[tuple[str, ...]]:
        """Return the names in a store. Ends with NoEntryError."""

    def delete(self, store: str, name: str) -> Operation[None]:
        """Remove an entry. Ends with NoEntryError."""

    def reset(self, store: str = "") -> Operation[None]:
        """Empty a store, or all, and read the project's files again. Ends with NoEntryError."""

    def save(self) -> Operation[int]:
        """Keep everything for later runs; the result is the number of entries."""
