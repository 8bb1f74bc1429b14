"""A sensor as a project declares it: a camera of the world, or topics with the types of what they carry.

Declared, not asked of the running sensor: a task can be drawn and checked with no sensor alive.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, StringConstraints, field_validator, model_validator

from grip_bt.base.frozen import FrozenDict
from grip_bt.base.types import parse_type

from .component_parts import Part, Start

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
PortName = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*$")]
Topic = Annotated[str, StringConstraints(pattern=r"^(/[A-Za-z_][A-Za-z0-9_]*)+$")]


class TopicConfig(Part):
    """One topic of a sensor; an output of its node."""

    topic: Topic
    type: str
    """Type of the output: a value (`PointCloud`), a builtin, or the ROS type itself."""
    message: str | None = None
    """ROS type of the topic; the usual one of the value where nothing is said."""
    doc: str = ""

    @field_validator("type")
    @classmethod
    def _type_exists(cls, value: str) -> str:
        parse_type(value)
        return value

    @model_validator(mode="after")
    def _message_is_known(self) -> TopicConfig:
        self.message_type()
        return self

    def message_type(self) -> str:
        """Return the ROS type of the topic.

        Raises:
            ValueError: nothing says it.
        """
        found = self.message or (self.type if "/" in self.type else MESSAGES.get(self.type))
        if found is None:
            raise ValueError(f"message: say which ROS type {self.topic} has, such as std_msgs/msg/Float64")
        return found


class Mount(Part):
    """Where a sensor's own frame is: on the world or on a link."""

    frame: str
    """Name of the sensor's frame, as its messages have it."""
    on: str = "world"
    """The link, or `world`."""
    position: tuple[float, ...] = (0.0, 0.0, 0.0)
    """In `on` [m]."""
    quaternion: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0)
    """w x y z."""


class SensorConfig(Part):
    """One sensor; its name makes the node `sensor/<name>`."""

    camera: str | None = None
    """Name of the camera in the simulated world or on the robot."""
    topics: FrozenDict[PortName, TopicConfig] = FrozenDict()
    """Outputs of the node, each from a topic; several are taken from one moment."""
    mount: Mount | None = None
    given_in: str | None = None
    """Frame into which what it gives is transformed."""
    driver: Start | None = None
    """How to start the sensor's driver; without it the driver is expected to run."""
    timeout: float = Field(default=2.0, gt=0)
    """How long one capture may take [s]."""
    slop: float = Field(default=0.05, gt=0)
    """How far the messages of one capture may be apart by their stamps [s]."""

    @model_validator(mode="after")
    def _has_a_source(self) -> SensorConfig:
        if (self.camera is None) == (not self.topics):
            raise ValueError("a sensor has either `camera`, in a simulated world, or `topics`")
        return self
