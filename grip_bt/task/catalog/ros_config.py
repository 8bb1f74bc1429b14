"""ROS as plain values, without ROS: a project's controllers, and interfaces as generators and checks see them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pydantic import Field, field_validator, model_validator

from grip_bt.base.frozen import FrozenDict
from grip_bt.base.yaml.models import RosName, Settings, exactly_one

from .sensors import Mount

MOVE_GROUP = "move_group"
"""What an arm's `planner` says when MoveIt plans for it."""
WAYS = ("trajectory", "topic", "positions", "move_group", "gripper")
"""How a controller may be reached."""


class ControllerConfig(Settings):
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
        exactly_one(self, WAYS)
        if self.instead_of and self.name is None:
            raise ValueError("`instead_of` needs the controller's own `name`: the two are switched in one step")
        return self


class MoveGroupConfig(Settings):
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


class CameraTopics(Settings):
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


class RosRobotConfig(Settings):
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


Kind = Literal["msg", "srv", "action"]

INTEGER_TYPES = frozenset(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)) | {"byte", "char"}
"""Primitive types that hold whole numbers."""


@dataclass(frozen=True, slots=True)
class FieldSpec:
    """One field.

    Attributes:
        name: the field's name.
        type: a primitive (`float64`, `string`) or a full message name (`geometry_msgs/msg/Pose`).
        array: whether it holds several.
        size: how many, exactly or at most; None when it isn't bounded, or isn't an array.
        bounded: whether `size` is an upper bound rather than exact.
        doc: the comment beside it.
    """

    name: str
    type: str
    array: bool = False
    size: int | None = None
    bounded: bool = False
    doc: str = ""

    @property
    def spelling(self) -> str:
        """The type as an interface file spells it, such as `geometry_msgs/Pose[<=3]`."""
        if not self.array:
            return self.type.replace("/msg/", "/")
        size = "" if self.size is None else f"<={self.size}" if self.bounded else str(self.size)
        return f"{self.type.replace('/msg/', '/')}[{size}]"

    @property
    def is_integer(self) -> bool:
        """Whether it holds one whole number."""
        return self.type in INTEGER_TYPES and not self.array


@dataclass(frozen=True, slots=True)
class InterfaceSpec:
    """One interface.

    Attributes:
        package: the ROS package that defines it.
        kind: `msg`, `srv` or `action`.
        name: its name in the package.
        request: fields of the request or goal; of the message itself for a `msg`.
        response: fields of the response or result; empty for a `msg`.
        feedback: fields of the feedback of an `action`.
        doc: the comment at the top of the file.
        source: the file it was read from.
    """

    package: str
    kind: Kind
    name: str
    request: tuple[FieldSpec, ...] = ()
    response: tuple[FieldSpec, ...] = ()
    feedback: tuple[FieldSpec, ...] = ()
    doc: str = ""
    source: str = ""

    @property
    def type_name(self) -> str:
        """Its full name, such as `std_srvs/srv/Trigger`."""
        return f"{self.package}/{self.kind}/{self.name}"
