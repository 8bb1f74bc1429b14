"""A point on the way of an arm, and how roundly it is passed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .joints import JointState
from .pose import Pose


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
