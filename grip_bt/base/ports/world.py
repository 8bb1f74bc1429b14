"""What a robot avoids and what it sees."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol, runtime_checkable

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
            DocumentError: it can't be read, or isn't one.
            UnknownNameError: the package isn't known.
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
        """Return the camera's geometry."""

    def capture(self) -> Operation[RgbdFrame]:
        """Take one frame. Ends with SensorError when there is none."""


@runtime_checkable
class Sensor(Protocol):
    """A sensor that gives one or several values of one moment."""

    def capture(self) -> Operation[Mapping[str, object]]:
        """Take one value of each output, by name. Ends with SensorError or ServerTimeOutError."""
