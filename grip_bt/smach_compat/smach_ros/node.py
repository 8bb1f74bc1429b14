"""`SmachNode` of the ROS 2 branch: a node that spins in a thread."""

from __future__ import annotations

import importlib
from typing import Any


def __getattr__(name: str) -> Any:
    """Make the class at its first use: it derives from rclpy's, which isn't loaded before."""
    if name == "__all__":
        return ["SmachNode"]
    if name == "SmachNode":
        return importlib.import_module("grip_bt.ros.smach_rclpy").SmachNode
    raise AttributeError(name)
