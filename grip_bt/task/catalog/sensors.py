"""Leaves that exist because a project has a sensor: `sensor/<name>` for each of them."""

from __future__ import annotations

from grip_bt.base.frozen import FrozenDict

from .manifest import Manifest, OutputPort, Parameter
from .sensor_config import SensorConfig

VIEW = {
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
        parameters=FrozenDict(VIEW),
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
        implementation="grip_bt.nodes.sensing:Sense",
        outputs=FrozenDict(outputs),
        codes=("no_data", "timed_out", "no_frame", "canceled"),
        settings=FrozenDict({"sensor": name}),
    )
