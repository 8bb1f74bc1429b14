"""A plausible value of any declared type: what fakes of sensors, topics and components give."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from grip_bt.base.failures import SensorError
from grip_bt.base.types import VALUES, Type, parse_type
from grip_bt.base.values import (
    CameraInfo,
    DepthImage,
    Failure,
    Grasp,
    Image,
    JointState,
    PathConstraint,
    Plan,
    PointCloud,
    Pose,
    RgbdFrame,
    Trajectory,
    WayPoint,
)

CAMERA = CameraInfo(
    64, 48, np.array([[60.0, 0, 32], [0, 60.0, 24], [0, 0, 1]]), Pose((0.5, 0.1, 1.3), (0, 0.70710678, -0.70710678, 0))
)
"""It looks down on a table from 1.3 m."""
_AT = Pose((0.5, 0.1, 0.1), (0.5, 0.5, 0.5, 0.5))
GRASP = Grasp(_AT, _AT.moved((-0.12, 0, 0)), _AT.moved((0, 0, 0.15)), width=0.06, provenance="fake")


def empty_table() -> RgbdFrame:
    """Return what the camera sees of a table with nothing on it."""
    shape = (CAMERA.height, CAMERA.width)
    return RgbdFrame(
        Image(np.full((*shape, 3), 170, np.uint8), "fake"), DepthImage(np.full(shape, 1.3, np.float32), CAMERA)
    )


def value_of(type_: str | Type) -> Any:
    """Return a value of a type: an empty one of the builtins, something small and sensible of GRIP's.

    Args:
        type_: as manifests and sensors declare it, such as `PointCloud`, `list[Grasp]` or `std_msgs/msg/Float64`.

    Raises:
        SensorError: it is a ROS message whose package isn't there.
    """
    wanted = parse_type(type_) if isinstance(type_, str) else type_
    if wanted.optional or wanted.name in ("Any", "None"):
        return None
    if wanted.name == "list":
        return [value_of(wanted.item)] if wanted.item is not None and wanted.item.name in VALUES else []
    if wanted.name == "dict":
        return {}
    return _message(wanted.name) if "/" in wanted.name else _VALUES[wanted.name]()


def _message(name: str) -> Any:
    from grip_bt.base.errors import MissingPartError, UnknownNameError

    try:
        from grip_bt.ros.types import load_type

        return load_type(name)()
    except (ImportError, MissingPartError, UnknownNameError) as error:
        reason = f"there is no fake of {name}: {error}; say what the node gives: --mock NODE=SCRIPT, or --mocks FILE"
        raise SensorError(reason, type=name) from None


def _points() -> PointCloud:
    x, y = np.meshgrid(np.linspace(0.3, 0.7, 12), np.linspace(-0.2, 0.2, 12))
    return PointCloud(np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1).astype(np.float32))


def _trajectory() -> Trajectory:
    return Trajectory(("joint",), np.array([0.0, 1.0]), np.zeros((2, 1)))


_VALUES: dict[str, Callable[[], Any]] = {
    "bool": bool,
    "int": int,
    "float": float,
    "str": str,
    "bytes": bytes,
    "CameraInfo": lambda: CAMERA,
    "DepthImage": lambda: empty_table().depth,
    "Failure": lambda: Failure("fake", "nothing has failed"),
    "Grasp": lambda: GRASP,
    "Image": lambda: empty_table().image,
    "JointState": lambda: JointState(("joint",), np.zeros(1)),
    "PathConstraint": PathConstraint,
    "Plan": lambda: Plan("arm", _trajectory(), "fake"),
    "PointCloud": _points,
    "Pose": lambda: _AT,
    "RgbdFrame": empty_table,
    "Trajectory": _trajectory,
    "WayPoint": lambda: WayPoint(_AT),
}
