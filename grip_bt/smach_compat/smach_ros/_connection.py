"""Which ROS this process uses: what was given, else rospy where it can be imported, else rclpy.

The connection is made by the first state or server that needs it, and not by importing this package.
"""

from __future__ import annotations

import importlib
import importlib.util
import threading
from typing import Any

from grip_bt import smach_compat as smach
from grip_bt.smach_compat import log, util

from ._port import Ros

_ADAPTERS = {"rospy": "grip_bt.ros.smach_rospy", "rclpy": "grip_bt.ros.smach_rclpy"}
_lock = threading.Lock()
_ros: Ros | None = None


def use(ros: Ros | None) -> None:
    """Use this adapter from now on; None to choose again at the next need.

    Args:
        ros: an adapter, for instance `grip_bt.ros.smach_rclpy.connect(domain_id=7)`.
    """
    global _ros
    with _lock:
        _ros = ros
        if ros is not None:
            _speak_through(ros)


def ros() -> Ros:
    """Return the process's ROS, connecting to it at the first call.

    Raises:
        MissingPartError: there is neither rospy nor rclpy; the message says what to install.
    """
    global _ros
    with _lock:
        if _ros is None:
            here = "rospy" if importlib.util.find_spec("rospy") else "rclpy"
            # By name: this room is below grip_bt.ros, and importing it must not load ROS.
            _ros = importlib.import_module(_ADAPTERS[here]).connect()
            _speak_through(_ros)
        return _ros


def _speak_through(ros: Ros) -> None:
    """Log by ROS and stop machines with it, as importing smach_ros does upstream; what the program has set stays."""
    if all(getattr(smach, name) is getattr(log, name) for name in ("loginfo", "logwarn", "logdebug", "logerr")):
        smach.set_loggers(*ros.loggers)
    if smach.is_shutdown is util.is_shutdown:
        smach.set_shutdown_check(ros.is_shutdown)


def seconds(duration: Any) -> float:
    """Return a duration in seconds: a number, a `rospy.Duration` or an rclpy one."""
    if hasattr(duration, "to_sec"):
        return float(duration.to_sec())
    if hasattr(duration, "nanoseconds"):
        return float(duration.nanoseconds) / 1e9
    return float(duration)
