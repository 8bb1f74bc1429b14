"""A film of a world in simulated time, and a last picture: taken where the physics is, so that no run waits for it."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from grip_bt.base.errors import GripError
from grip_sim.cameras.rig import Rig
from grip_sim.specs import CameraSpec

RATE = 25
"""Frames a second of simulated time."""


class Film:
    """Is filled while the world goes on; frames are taken without a sensor's faults, and change nothing.

    Args:
        camera: a camera of the world, or one that stands apart.
        start: time of the world [s].
        video: file that the film is written to, as MPEG-4; None for none.
        picture: file that gets a last picture; None for none.

    Raises:
        UnknownNameError: there is no such camera.
        GripError: a file can't be written.
    """

    def __init__(self, cameras: Rig, camera: str | CameraSpec, start: float, video: Path | None, picture: Path | None):
        self._cameras, self._camera, self._picture = cameras, camera, picture
        self._start, self._taken = start, 0
        if picture is not None and not (cv2.haveImageWriter(str(picture)) and picture.parent.is_dir()):
            raise GripError(f"{picture}: a picture can't be written there; its name must end in .png or .jpg")
        height, width = cameras.view(camera).depth.shape
        self._writer: cv2.VideoWriter | None = None
        if video is not None:
            self._writer = cv2.VideoWriter(str(video), cv2.VideoWriter.fourcc(*"mp4v"), RATE, (width, height))
            if not self._writer.isOpened():
                raise GripError(f"{video}: a video can't be written there; its name must end in .mp4")
        self.stepped(start)

    def stepped(self, time: float) -> None:
        """Take the frames that are due at a time of the world [s]."""
        while self._writer is not None and time >= self._start + self._taken / RATE - 1e-9:
            self._writer.write(self._frame())
            self._taken += 1

    def close(self) -> None:
        """End the film and take the last picture; harmless when it was closed before.

        Raises:
            GripError: the picture can't be written.
        """
        if self._writer is not None:
            self._writer.release()
            self._writer = None
        picture, self._picture = self._picture, None
        if picture is not None and not cv2.imwrite(str(picture), self._frame()):
            raise GripError(f"{picture}: a picture can't be written there")

    def _frame(self) -> np.ndarray:
        return np.ascontiguousarray(self._cameras.view(self._camera).image[:, :, ::-1])
