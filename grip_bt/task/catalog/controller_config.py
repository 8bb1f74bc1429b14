"""How a project's real robot is reached: the controllers of its arms and hands, as `grip.yaml` declares them."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, StringConstraints, field_validator, model_validator

from grip_bt.base.frozen import FrozenDict

from .component_parts import Part
from .sensor_config import Mount

RosName = Annotated[str, StringConstraints(pattern=r"^(/[A-Za-z_][A-Za-z0-9_]*)+$")]
MOVE_GROUP = "move_group"
"""What an arm's `planner` says when MoveIt plans for it."""
WAYS = ("trajectory", "topic", "positions", "move_group", "gripper")
"""How a controller may be reached."""


class ControllerConfig(Part):
    """The controller of one arm or hand; exactly one of the five ways to reach it."""

    trajectory: RosName | None = None
    """Action of a joint trajectory controller, such as `/arm_controller/follow_joint_trajectory`."""
    topic: RosName | None = None
    """Topic of a joint trajectory controller, such as `/arm_controller/joint_trajectory`, for want of its action."""
    positions: RosName | None = None
    """Topic of a joint group position controller, such as `/arm_position_controller/commands`."""
    move_group: RosName | None = None
    """Action by which MoveIt's move_group executes trajectories, such as `/execute_trajectory`."""
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
        ways = [w for w in WAYS if getattr(self, w) is not None]
        if len(ways) != 1:
            said = " and ".join(ways) or "none of them"
            raise ValueError(f"say one of {', '.join(f'`{way}`' for way in WAYS)}; here: {said}")
        if self.instead_of and self.name is None:
            raise ValueError("`instead_of` needs the controller's own `name`: the two are switched in one step")
        return self


class MoveGroupConfig(Part):
    """MoveIt 2's move_group, the planner of arms that say `planner: move_group`."""

    namespace: RosName | Literal[""] = ""
    """Namespace of its services and actions: none, or such as `/left`."""
    pipeline: str = ""
    """Its planning pipeline, such as `ompl` or `pilz_industrial_motion_planner`; its own default when empty."""
    planner: str = ""
    """Its planner, such as `RRTConnectkConfigDefault` or `PTP`; its own default when empty."""
    groups: FrozenDict[str, str] = FrozenDict()
    """Group of the robot here -> the group's name in MoveIt's SRDF, where that is another."""
    by_service: bool = False
    """Plan by the service `plan_kinematic_path`; a plan can't be cancelled then."""
    wait: float = Field(default=10.0, gt=0)
    """How long move_group may take to be there [s]."""


class CameraTopics(Part):
    """The topics of an RGB-D camera: what a sensor that says `camera` is on a real robot."""

    image: RosName
    """Colour, such as `/camera/color/image_raw`."""
    depth: RosName
    """Depth in the view of the colour camera, such as `/camera/aligned_depth_to_color/image_raw`."""
    info: RosName
    """Geometry of the colour camera, such as `/camera/color/camera_info`."""
    mount: Mount | None = None
    """Where its optical frame is; without it, TF says so."""
    timeout: float = Field(default=5.0, gt=0)
    """How long one capture may take [s]."""
    slop: float = Field(default=0.05, gt=0)
    """How far the messages of one capture may be apart by their stamps [s]."""


class RosRobotConfig(Part):
    """The robot of `grip run --robot ros`."""

    joint_states: RosName = "/joint_states"
    """Topic on which all joints are measured."""
    controller_manager: RosName = "/controller_manager"
    controllers: FrozenDict[str, ControllerConfig] = FrozenDict()
    """Arm or hand of the project -> its controller."""
    cameras: FrozenDict[str, CameraTopics] = FrozenDict()
    """Sensor of the project that says `camera` -> the topics of that camera."""
    move_group: MoveGroupConfig = MoveGroupConfig()
    """MoveIt, where an arm says `planner: move_group`."""
    ready: float = Field(default=10.0, gt=0)
    """How long the robot may take to be there [s]."""
    stale: float = Field(default=1.0, gt=0)
    """A joint that wasn't heard of for so long [s] isn't known any more, and a motion that needs it ends."""

    @field_validator("controllers")
    @classmethod
    def _some(cls, value: FrozenDict[str, ControllerConfig]) -> FrozenDict[str, ControllerConfig]:
        if not value:
            raise ValueError("name the controller of each arm and hand")
        return value
