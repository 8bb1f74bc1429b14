"""Cameras of simulated worlds; whether SAPIEN's renderer works is tried in another process, which a bad driver ends."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

from grip_bt.base.interpreter import python_command

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
