"""A fake camera: frames from a list."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import cycle

from grip_bt.base.failures import ExpectedError, SensorError
from grip_bt.base.operation import Operation
from grip_bt.base.values import CameraInfo, RgbdFrame


class FakeCamera:
    """Implements `ports.Camera`.

    Args:
        info: the camera's geometry.
        frames: what the captures give, one after the other, again and again; an error stands for a failed capture.
    """

    def __init__(self, info: CameraInfo, frames: Iterable[RgbdFrame | ExpectedError] = ()):
        self._info = info
        self._frames = cycle(tuple(frames))

    def info(self) -> CameraInfo:
        """Return the camera's geometry."""
        return self._info

    def capture(self) -> Operation[RgbdFrame]:
        """Take the next frame; SensorError where there is none."""
        frame = next(self._frames, SensorError("the fake camera has no frames"))
        return Operation.failed(frame) if isinstance(frame, ExpectedError) else Operation.finished(frame)
