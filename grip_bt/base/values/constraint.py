"""What a motion keeps to on its whole way: an orientation within tolerances, a position within a box."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ._frozen import ComparesArrays
from .pose import Pose, check_frame


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
