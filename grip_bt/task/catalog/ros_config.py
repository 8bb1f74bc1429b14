"""A project's sensors, controllers and ROS interfaces as plain values, without ROS."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Literal

from pydantic import Field, field_validator, model_validator

from grip_bt.base.frozen import FrozenDict
from grip_bt.base.yaml.models import Identifier, RosName, Settings, exactly_one
from grip_bt.task.catalog.component_file import Kind
from grip_bt.task.catalog.manifest import Manifest, OutputPort, TypeName, read_manifests
from grip_bt.task.catalog.start import Start

MESSAGES = {
    "PointCloud": "sensor_msgs/msg/PointCloud2",
    "Image": "sensor_msgs/msg/Image",
    "DepthImage": "sensor_msgs/msg/Image",
    "CameraInfo": "sensor_msgs/msg/CameraInfo",
    "JointState": "sensor_msgs/msg/JointState",
    "Pose": "geometry_msgs/msg/PoseStamped",
    "Trajectory": "trajectory_msgs/msg/JointTrajectory",
}
"""The message that carries a value, where nothing else is said."""


class TopicConfig(Settings):
    """One topic of a sensor; an output of its node."""

    topic: RosName
    """Name of the topic."""
    type: TypeName
    """Type of the output: a value (`PointCloud`), a builtin, or the ROS type itself."""
    message: str | None = None
    """ROS type of the topic; the usual one of the value where nothing is said."""
    doc: str = ""
    """A sentence about the output."""

    @model_validator(mode="after")
    def _message_is_known(self) -> TopicConfig:
        self.message_type()
        return self

    def message_type(self) -> str:
        """Return the ROS type of the topic; ValueError where nothing says it."""
        found = self.message or (self.type if "/" in self.type else MESSAGES.get(self.type))
        if found is None:
            raise ValueError(f"message: say which ROS type {self.topic} has, such as std_msgs/msg/Float64")
        return found


class Mount(Settings):
    """Where a sensor's own frame is: on the world or on a link."""

    frame: str
    """Name of the sensor's frame, as its messages have it."""
    on: str = "world"
    """The link, or `world`."""
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """In `on` [m]."""
    quaternion: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    """w x y z."""


class SensorConfig(Settings):
    """One sensor; its name makes the node `sensor/<name>`."""

    camera: str | None = None
    """Name of the camera in the simulated world or on the robot."""
    topics: FrozenDict[Identifier, TopicConfig] = FrozenDict()
    """Outputs of the node, each from a topic; several are taken from one moment."""
    mount: Mount | None = None
    """Where its frame is; without it, TF says so."""
    given_in: str | None = None
    """Frame into which what it gives is transformed."""
    driver: Start | None = None
    """How to start the sensor's driver; without it the driver is expected to run."""
    timeout: float = Field(default=2.0, gt=0)
    """How long one capture may take [s]."""
    slop: float = Field(default=0.05, gt=0)
    """Largest difference between the stamps of one capture [s]."""

    @model_validator(mode="after")
    def _has_a_source(self) -> SensorConfig:
        if (self.camera is None) == (not self.topics):
            raise ValueError("a sensor has either `camera`, in a simulated world, or `topics`")
        return self


@cache
def _camera() -> Manifest:
    (found,) = read_manifests(Path(__file__).with_name("camera.yaml"))
    return found


def sensor_manifest(name: str, sensor: SensorConfig | None = None) -> Manifest:
    """Return the manifest of the leaf that takes one frame with the project's sensor `name`.

    Args:
        sensor: what is declared of it; a camera where nothing is.
    """
    if sensor is not None and sensor.topics:
        return _of_topics(name, sensor)
    own = {"id": f"sensor/{name}", "doc": _camera().doc.replace("NAME", name), "settings": FrozenDict({"sensor": name})}
    return _camera().model_copy(update=own)


def _of_topics(name: str, sensor: SensorConfig) -> Manifest:
    several = f", from messages at most {sensor.slop} s apart" if len(sensor.topics) > 1 else ""
    outputs = {
        port: OutputPort(type=topic.type, doc=topic.doc or f"from {topic.topic}")
        for port, topic in sensor.topics.items()
    }
    return Manifest(
        id=f"sensor/{name}",
        doc=f"Take what the sensor `{name}` gives{several}, within {sensor.timeout} s.",
        implementation="grip_bt.nodes.perception:Sense",
        outputs=FrozenDict(outputs),
        codes=("no_data", "timed_out", "no_frame", "canceled"),
        settings=FrozenDict({"sensor": name}),
    )


MOVE_GROUP = "move_group"
"""What an arm's `planner` says when MoveIt plans for it."""
WAYS = ("trajectory", "topic", "positions", "move_group", "gripper")
"""How a controller may be reached."""


class SignalConfig(Settings):
    """A number on a topic: a force, or how fast something slips."""

    topic: RosName
    """Name of the topic."""
    message: str = "geometry_msgs/msg/WrenchStamped"
    """ROS type of the topic."""
    field: str = "wrench.force"
    """Where the number is in the message, such as `data` or `data[2]`; of a vector it is the length."""


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
    wrench: RosName | None = None
    """Topic of geometry_msgs/msg/WrenchStamped of an arm's force-torque sensor, in a link's frame or in `world`."""
    contacts: FrozenDict[str, SignalConfig] = FrozenDict()
    """Link of a hand -> how hard it presses [N]."""
    slips: FrozenDict[str, SignalConfig] = FrozenDict()
    """Link of a hand -> how fast something slides along it [m/s]; of a truth value, 1 m/s or nothing."""

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
    """Largest difference between the stamps of one capture [s]."""


class RosRobotConfig(Settings):
    """The robot of `grip run --robot ros`."""

    namespace: RosName | None = None
    """Where joint states, controller manager and move_group are, unless their own keys say otherwise."""
    joint_states: RosName = "/joint_states"
    """Topic on which all joints are measured."""
    controller_manager: RosName = "/controller_manager"
    """Namespace of the controller manager's services."""
    controllers: FrozenDict[str, ControllerConfig] = FrozenDict()
    """Arm or hand of the project -> its controller."""
    cameras: FrozenDict[str, CameraTopics] = FrozenDict()
    """Sensor of the project that says `camera` -> the topics of that camera."""
    move_group: MoveGroupConfig = MoveGroupConfig()
    """MoveIt, where an arm says `planner: move_group`."""
    ready: float = Field(default=10.0, gt=0)
    """How long the robot may take to be there [s]."""
    stale: float = Field(default=1.0, gt=0)
    """A joint without a message for this time [s] is unknown, and a motion that needs it ends."""

    @model_validator(mode="before")
    @classmethod
    def _in_namespace(cls, data: object) -> object:
        if not isinstance(data, dict) or not data.get("namespace"):
            return data
        inside = {key: f"{data['namespace']}/{key}" for key in ("joint_states", "controller_manager")}
        planner = data.get("move_group", {})
        planner = {"namespace": data["namespace"], **planner} if isinstance(planner, dict) else planner
        return {**inside, **data, "move_group": planner}

    @field_validator("controllers")
    @classmethod
    def _some(cls, value: FrozenDict[str, ControllerConfig]) -> FrozenDict[str, ControllerConfig]:
        if not value:
            raise ValueError("name the controller of each arm and hand")
        return value


INTEGER_TYPES = frozenset(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)) | {"byte", "char"}
"""Primitive types that hold whole numbers."""


@dataclass(frozen=True, slots=True)
class FieldSpec:
    """One field.

    Attributes:
        type: a primitive (`float64`, `string`) or a full message name (`geometry_msgs/msg/Pose`).
        size: how many, exactly or at most; None when it isn't bounded, or isn't an array.
        bounded: whether `size` is an upper bound rather than exact.
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
        request: fields of the request or goal; of the message itself for a `msg`.
        response: fields of the response or result; empty for a `msg`.
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
