"""How an arm is planned for: the fields of an arm in `grip.yaml`, and what a request adds to them."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

PLANNERS = (
    *("AORRTC", "BFMT", "BITstar", "BKPIECE1", "BiTRRT", "FMT", "InformedRRTstar", "KPIECE1", "LBKPIECE1", "PRM"),
    *("PRMstar", "RRT", "RRTConnect", "RRTstar", "SORRTstar"),
)
"""The planners that OMPL's wheel binds, and our own BiTRRT; a test compares them."""
SOLVERS = ("damped_least_squares", "trac_ik")
"""The keys of `ik.SOLVERS`; likewise."""


class MotionSettings(BaseModel):
    """How an arm is asked to move; the defaults are those of a project."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    planner: str = "RRTConnect"
    """A planner of OMPL, such as `RRTConnect` or `BiTRRT`; `move_group` for MoveIt's."""
    kinematics: str = "damped_least_squares"
    """Inverse kinematics: `damped_least_squares` or `trac_ik`."""
    speed: float = Field(default=0.5, gt=0, le=1)
    """Fraction of the joints' speed limits."""
    acceleration: float | None = Field(default=None, gt=0, le=1)
    """Fraction of the joints' acceleration limits; as `speed` when it isn't given."""
    jerk: float | None = Field(default=None, gt=0, le=1)
    """Fraction of the joints' jerk limits (`max_jerk` in `joint_limits.yaml`); any jerk when it isn't given."""
    planning_time: float = Field(default=2.0, gt=0)
    """CPU time for one request, all attempts together [s]; wall time ends it at 20 times as much."""
    attempts: int = Field(default=3, ge=1)
    """How many searches, with other random numbers, before giving up."""


class PlanningSettings(MotionSettings):
    """How to plan."""

    margin: float = Field(default=0.01, ge=0)
    """Distance to keep from the scene's objects where start and goal leave room for it [m]."""
    seed: int = 0
    """The same request with the same seed gives the same plan."""
