"""The geometry of simulated cameras, without the simulator."""

from __future__ import annotations

import numpy as np

from grip_bt.base.values import CameraInfo, Pose
from grip_sim.specs import CameraSpec


def camera_info(spec: CameraSpec) -> CameraInfo:
    """Return the geometry of a camera."""
    f = spec.height / 2 / np.tan(spec.field_of_view / 2)
    matrix = [[f, 0, spec.width / 2], [0, f, spec.height / 2], [0, 0, 1]]
    return CameraInfo(spec.width, spec.height, np.array(matrix), Pose(spec.position, spec.quaternion))
