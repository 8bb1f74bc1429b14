"""How a project's real robot is reached: the controllers of its arms and hands, as `grip.yaml` declares them."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, StringConstraints, field_validator, model_validator

from grip_bt.graph.frozen import FrozenDict

from .component_parts import Part

RosName = Annotated[str, StringConstraints(pattern=r"^(/[A-Za-z_][A-Za-z0-9_]*)+$")]


class ControllerConfig(Part):
    """The controller of one arm or hand; exactly one of `trajectory`, `positions` and `gripper`."""

    trajectory: RosName | None = None
    """Action of a joint trajectory controller, such as `/arm_controller/follow_joint_trajectory`."""
    positions: RosName | None = None
    """Topic of a joint group position controller, such as `/arm_position_controller/commands`."""
    gripper: RosName | None = None
    """Action of a gripper, such as `/gripper_controller/gripper_cmd`; of hands only."""
    joints: tuple[str, ...] = ()
    """The joints that it moves, in its order: all of the group's by default."""
    name: str | None = None
    """Its name in the controller manager, which then makes it active."""
    instead_of: tuple[str, ...] = ()
    """Controllers of the same joints, which the controller manager then deactivates."""

    @model_validator(mode="after")
    def _one_way(self) -> ControllerConfig:
        ways = [w for w in ("trajectory", "positions", "gripper") if getattr(self, w) is not None]
        if len(ways) != 1:
            said = " and ".join(ways) or "none of them"
            raise ValueError(f"say one of `trajectory`, `positions`, `gripper`; here: {said}")
        if self.instead_of and self.name is None:
            raise ValueError("`instead_of` needs the controller's own `name`: the two are switched in one step")
        return self


class RosRobotConfig(Part):
    """The robot of `grip run --robot ros`."""

    joint_states: RosName = "/joint_states"
    """Topic on which all joints are measured."""
    controller_manager: RosName = "/controller_manager"
    controllers: FrozenDict[str, ControllerConfig] = FrozenDict()
    """Arm or hand of the project -> its controller."""
    ready: float = Field(default=10.0, gt=0)
    """How long the robot may take to be there [s]."""

    @field_validator("controllers")
    @classmethod
    def _some(cls, value: FrozenDict[str, ControllerConfig]) -> FrozenDict[str, ControllerConfig]:
        if not value:
            raise ValueError("name the controller of each arm and hand")
        return value
