"""What cameras of simulated worlds take, what renderers have in common, and which of them works here.

Whether SAPIEN's does is tried in a process of its own, since a bad driver can end one.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from grip_bt.base.arrays import Array
from grip_bt.base.interpreter import python_command
from grip_bt.base.values import Pose
from grip_bt.base.values.pose import rotation_rows
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
    time: float = 0.0


class Places(NamedTuple):
    """Where bodies are: rotations of shape (n, 3, 3) and positions of shape (n, 3) [m], in world."""

    rotations: Array
    positions: Array

    @classmethod
    def of(cls, rows: Array | Sequence[Sequence[float]]) -> Places:
        """Return them from rows x y z and a quaternion w x y z."""
        rows = np.asarray(rows, float).reshape(-1, 7)
        turns = rotation_rows(*(rows[:, 3:] / np.linalg.norm(rows[:, 3:], axis=1, keepdims=True)).T)
        return cls(np.array(turns).transpose(2, 0, 1), rows[:, :3])


class Renderer(Protocol):
    """Draws the same bodies from anywhere."""

    def draw(self, pose: Pose, places: Places) -> Frame:
        """Return what is seen by a camera at `pose` of bodies at `places`, in their order."""


_PROBE = "import sapien; sapien.render.RenderSystem(); print(sapien.render.get_device_summary())"
_FILES, _LIST = ("VK_DRIVER_FILES", "VK_ICD_FILENAMES"), "VK_ADD_DRIVER_FILES"
_FOLDERS = ("XDG_CONFIG_HOME", "XDG_CONFIG_DIRS", "XDG_DATA_HOME", "XDG_DATA_DIRS")


@lru_cache(maxsize=1)
def vulkan_works() -> bool:
    """Tell whether SAPIEN can render: at once where no Vulkan driver is installed, else by a trial of a second."""
    return any(_drivers()) and _tried()


def _drivers() -> Iterator[Path]:
    """Yield the descriptions of Vulkan drivers, where the loader looks for them."""
    told = [os.environ[name] for name in (*_FILES, _LIST) if os.environ.get(name)]
    yield from (path for text in told for path in map(Path, text.split(os.pathsep)) if path.exists())
    if any(os.environ.get(name) for name in _FILES):
        return
    named = [folder for name in _FOLDERS for folder in os.environ.get(name, "").split(os.pathsep) if folder]
    for folder in (*named, "/etc/xdg", "/etc", "/usr/local/share", "/usr/share", str(Path.home() / ".local/share")):
        yield from Path(folder, "vulkan", "icd.d").glob("*.json")


def _tried() -> bool:
    command = python_command("-W", "ignore", "-c", _PROBE)
    try:
        return subprocess.run(command, capture_output=True, timeout=60).returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        return False


def render_support() -> str:
    """Return in a line which renderer the cameras of simulations use here."""
    if vulkan_works():
        return "SAPIEN's renderer, by Vulkan (a camera with `renderer: raster` draws on the CPU)"
    return "triangles drawn on the CPU (OpenCV); SAPIEN's renderer has no usable Vulkan driver here, and isn't needed"
