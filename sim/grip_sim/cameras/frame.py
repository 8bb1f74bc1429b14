"""What a camera takes, and what the renderers have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from grip_bt.base.arrays import Array
from grip_bt.base.values import Pose
from grip_sim.specs import Colour

LIGHT = np.array([0.35, -0.25, 0.9]) / np.linalg.norm([0.35, -0.25, 0.9])
"""Where the light comes from, in world."""
AMBIENT, DIFFUSE = 0.45, 0.55
BACKGROUND: Colour = (24, 26, 30)
NOTHING = -1
NEAR = 0.01
"""Nothing is seen nearer than this [m]."""


@dataclass(frozen=True)
class Frame:
    """One capture.

    Attributes:
        image: shape (height, width, 3) uint8.
        depth: shape (height, width) float32, along the optical axis [m]; 0 where nothing is.
        labels: shape (height, width) int16, index into `names`, -1 where nothing is. For referees only.
        names: of what can be seen.
        normals: shape (height, width, 3) float32, of the surfaces, in the optical frame; 0 where nothing is.
        pose: of the optical frame in world.
        time: of the world, when it was taken [s].
    """

    image: NDArray[np.uint8]
    depth: NDArray[np.float32]
    labels: NDArray[np.int16]
    names: tuple[str, ...]
    normals: NDArray[np.float32]
    pose: Pose
    time: float = field(default=0.0)


class Places(NamedTuple):
    """Where bodies are: rotations of shape (n, 3, 3) and positions of shape (n, 3) [m], in world."""

    rotations: Array
    positions: Array

    @classmethod
    def of(cls, rows: Array | Sequence[Sequence[float]]) -> Places:
        """Return them from rows x y z and a quaternion w x y z."""
        rows = np.asarray(rows, float).reshape(-1, 7)
        w, x, y, z = (rows[:, 3:] / np.linalg.norm(rows[:, 3:], axis=1, keepdims=True)).T
        turns = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
        return cls(np.array(turns).transpose(2, 0, 1), rows[:, :3])


class Renderer(Protocol):
    """Draws the same bodies from anywhere."""

    def draw(self, pose: Pose, places: Places) -> Frame:
        """Return what is seen by a camera at `pose` of bodies at `places`, in their order."""
