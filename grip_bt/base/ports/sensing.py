"""What sees."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

from grip_bt.base.operation import Operation
from grip_bt.base.values import CameraInfo, RgbdFrame


@runtime_checkable
class Camera(Protocol):
    """An RGB-D camera."""

    def info(self) -> CameraInfo:
        """Return the camera's geometry."""

    def capture(self) -> Operation[RgbdFrame]:
        """Take one frame. Ends with SensorError when there is none."""


@runtime_checkable
class Sensor(Protocol):
    """A sensor that gives one or several values of one moment."""

    def capture(self) -> Operation[Mapping[str, Any]]:
        """Take one value of each output, by name. Ends with SensorError or ServerTimeOutError."""
