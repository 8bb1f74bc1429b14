"""Leaves that exist because a project has a sensor: `sensor/<name>` for each of them."""

from __future__ import annotations

from grip_bt.graph.frozen import FrozenDict

from .manifest import Manifest, OutputPort


def sensor_manifest(name: str) -> Manifest:
    """Return the manifest of the leaf that takes one frame with the project's sensor `name`."""
    return Manifest(
        id=f"sensor/{name}",
        doc=f"Take one RGB-D frame with the sensor `{name}`.",
        implementation="grip_bt.nodes.perception:Capture",
        outputs=FrozenDict(
            {
                "frame": OutputPort(type="RgbdFrame", doc="colour and depth of one moment"),
                "points": OutputPort(type="PointCloud", doc="the seen points in the frame of the camera's pose"),
            }
        ),
        codes=("no_data", "time_out", "canceled"),
        settings=FrozenDict({"sensor": name}),
    )
