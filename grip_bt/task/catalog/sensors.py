"""Sensors as a project declares them, and the leaf `sensor/<name>` of each.

A task can be drawn and checked with no sensor alive.
"""

from __future__ import annotations

from pydantic import Field, field_validator, model_validator

from grip_bt.base.frozen import FrozenDict
from grip_bt.base.types import parse_type
from grip_bt.base.yaml.models import Identifier, RosName, Settings

from .component_parts import Start
from .manifest import Manifest, OutputPort, Parameter

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


class Mount(Settings):
    """Where a sensor's own frame is: on the world or on a link."""

    frame: str
    """Name of the sensor's frame, as its messages have it."""
    on: str = "world"
    """The link, or `world`."""
    position: tuple[float, ...] = (0.0, 0.0, 0.0)
    """In `on` [m]."""
    quaternion: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0)
    """w x y z."""


class SensorConfig(Settings):
    """One sensor; its name makes the node `sensor/<name>`."""

    camera: str | None = None
    """Name of the camera in the simulated world or on the robot."""
    topics: FrozenDict[Identifier, TopicConfig] = FrozenDict()
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


_VIEW = {
    "max_hidden": Parameter(
        type="float", default=0.1, doc="share of the view that the robot may hide, 0..1; 1 for whatever it hides"
    ),
    "region": Parameter(
        type="list[float]",
        default=[],
        doc="what counts of the view: x from, x to, y from, y to [m]; empty for all of it",
    ),
    "table": Parameter(type="float", default=0.0, doc="height of the region in world [m]"),
}
"""Parameters of a camera's node that say which view is good enough."""


def sensor_manifest(name: str, sensor: SensorConfig | None = None) -> Manifest:
    """Return the manifest of the leaf that takes one frame with the project's sensor `name`.

    Args:
        name: the sensor's name.
        sensor: what is declared of it; a camera where nothing is.
    """
    if sensor is not None and sensor.topics:
        return _of_topics(name, sensor)
    return Manifest(
        id=f"sensor/{name}",
        doc=(
            f"Take one RGB-D frame with the sensor `{name}`. Fails with `view_blocked` when the robot hides too much of"
            " the view, as its joints and its description tell."
        ),
        implementation="grip_bt.nodes.perception:Capture",
        parameters=FrozenDict(_VIEW),
        outputs=FrozenDict(
            {
                "frame": OutputPort(type="RgbdFrame", doc="colour and depth of one moment"),
                "points": OutputPort(
                    type="PointCloud", doc="the seen points in the frame of the camera's pose, without the robot's own"
                ),
                "hidden": OutputPort(
                    type="float", on=("success", "failure"), doc="share of the view that the robot hides, 0..1"
                ),
            }
        ),
        codes=("view_blocked", "no_data", "time_out", "canceled"),
        settings=FrozenDict({"sensor": name}),
    )


def _of_topics(name: str, sensor: SensorConfig) -> Manifest:
    """Return the manifest of the leaf that takes one message of each topic, from one moment."""
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
