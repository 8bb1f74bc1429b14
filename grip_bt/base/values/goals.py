"""Where motions go: grasps, way points, and what a path keeps to on its whole way."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from grip_bt.base.arrays import Array, ComparesArrays

from .joints import JointState
from .pose import Pose, check_frame


@dataclass(frozen=True, slots=True, eq=False)
class Grasp(ComparesArrays):
    """One way to take an object. All poses are of the hand's grasp frame (see `RobotModel.grasp_frame`), in one frame.

    Attributes:
        pose: where the hand closes.
        pre_grasp: where the straight approach begins.
        post_grasp: where the straight lift ends.
        pre_posture: hand joints during the approach; None means the hand's `open` posture.
        posture: hand joints to close towards; None means the hand's `closed` posture.
        torque_limit: largest joint torque while closing [N m].
        width: size of the object between the fingers [m]; 0 where unknown.
        quality: larger is better; comparable only within one proposer.
    """

    pose: Pose
    pre_grasp: Pose
    post_grasp: Pose
    pre_posture: JointState | None = None
    posture: JointState | None = None
    torque_limit: float = 0.7
    width: float = 0.0
    quality: float = 0.0
    provenance: str = ""

    def __post_init__(self) -> None:
        frames = {self.pose.frame, self.pre_grasp.frame, self.post_grasp.frame}
        if len(frames) > 1:
            raise ValueError(f"the poses of a grasp are given in one frame, not in {sorted(frames)}")

    def closing_points(self) -> Array:
        """Return where the object may be, the likeliest first, shape (3, 3) [m]: along the palm's normal.

        Its middle is half its width in front of the palm or, for a pinch with the finger tips, further out.
        """
        depths = np.array([[max(self.width, 0.03) / 2], [0.06], [0.09]])
        return np.asarray(self.pose.position + depths * self.pose.rotation()[:, 2])


@dataclass(frozen=True, slots=True)
class Failure:
    """Why a node failed.

    Attributes:
        code: short, stable word for branching and for tables, such as `no_ik`.
        data: what may help to mend it.
    """

    code: str
    message: str = ""
    data: dict[str, object] = field(default_factory=dict)

    def __str__(self) -> str:
        return f"{self.code}: {self.message}" if self.message else self.code


@dataclass(frozen=True, slots=True, eq=False)
class PathConstraint(ComparesArrays):
    """Where a hand's grasp frame may be on the way.

    Attributes:
        orientation: the pose, in world, whose orientation is kept; its position doesn't matter. None: any orientation.
        tolerance: largest turns away from it about three axes [rad]; `inf` leaves an axis free. A full cup that may
            turn about the vertical has `(0.1, 0.1, inf)` about the axes of the world.
        axes: whether these are the axes of the `world` or those of `orientation` (`own`).
        box: centre and attitude of a box in world that the frame's origin stays in, or None.
        size: the box's edge lengths [m].

    Raises:
        ValueError: a tolerance or a length isn't positive, or a pose isn't in world.
    """

    orientation: Pose | None = None
    tolerance: tuple[float, float, float] = (0.1, 0.1, np.inf)
    axes: Literal["world", "own"] = "world"
    box: Pose | None = None
    size: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        for name in ("tolerance", "size"):
            numbers = tuple(float(value) for value in getattr(self, name))
            if len(numbers) != 3 or not all(value > 0 for value in numbers):
                raise ValueError(f"{name} is 3 positive numbers, not {list(numbers)}")
            object.__setattr__(self, name, numbers)
        if self.axes not in ("world", "own"):
            raise ValueError(f"tolerances are about the axes `world` or `own`, not {self.axes!r}")
        for pose in (self.orientation, self.box):
            if pose is not None:
                check_frame(pose, "world")

    def kept_by(self, pose: Pose, slack: float = 1e-6) -> bool:
        """Tell whether a grasp frame at `pose`, in world, is within the tolerances, up to `slack` [rad, m]."""
        check_frame(pose, "world")
        if self.orientation is not None:
            away = self.orientation.inverse() @ pose
            turn = away.rotation_vector()
            turn = self.orientation.rotation() @ turn if self.axes == "world" else turn
            if (np.abs(turn) > np.array(self.tolerance) + slack).any():
                return False
        if self.box is None:
            return True
        offset = self.box.rotation().T @ (pose.position - self.box.position)
        return bool((np.abs(offset) <= np.array(self.size) / 2 + slack).all())


@dataclass(frozen=True, slots=True)
class WayPoint:
    """Where a segment of a motion ends.

    Attributes:
        goal: joint positions, a pose of the grasp frame in world, or the name of a state of the arm.
        radius: the grasp frame's origin may leave its way within this distance of the point, to pass it without a stop
            [m]; 0: the arm comes to rest there. Of the last point it doesn't matter: the arm comes to rest.
        straight: whether the segment is straight: for a pose a line of the grasp frame, for joint positions a line in
            joint space. Otherwise a path around obstacles is searched.

    Raises:
        ValueError: the radius is negative or not finite.
    """

    goal: JointState | Pose | str
    radius: float = 0.0
    straight: bool = True

    def __post_init__(self) -> None:
        if not (np.isfinite(self.radius) and self.radius >= 0):
            raise ValueError(f"a blend radius is a length [m], 0 or more, not {self.radius}")
