"""What this machine could render with. The ray-cast camera needs none of it and is what simulations use."""

from __future__ import annotations

import subprocess

from grip_bt.base.interpreter import python_command

_PROBE = "import sapien; sapien.render.RenderSystem(); print(sapien.render.get_device_summary())"


def render_support() -> str:
    """Return in a line which camera simulations use here, and whether SAPIEN's renderer would work.

    The renderer is tried in a process of its own, since a bad driver can end it.
    """
    command = python_command("-W", "ignore", "-c", _PROBE)
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=60)
        works = done.returncode == 0
    except subprocess.TimeoutExpired:
        works = False
    vulkan = "works here too, unused" if works else "has no usable Vulkan driver here, and isn't needed"
    return f"ray-cast camera; SAPIEN's renderer {vulkan}"
