"""The `smach_ros` library again: states that use ROS, and machines on the network.

Signatures of ROS 1 (no node) and of ROS 2 (a node first) are both taken. It runs on rospy where that can be imported,
else on rclpy; importing it loads neither. `use` gives it another connection.
"""

from __future__ import annotations

import importlib
import sys
from typing import Any

from grip_bt.smach_compat._settings import settings

from . import action_server_wrapper as action_server_wrapper
from . import introspection as introspection
from . import ros_state as ros_state
from . import service_state as service_state
from . import simple_action_state as simple_action_state
from . import util as util
from ._connection import use as use
from .action_server_wrapper import ActionServerWrapper as ActionServerWrapper
from .introspection import IntrospectionClient as IntrospectionClient
from .introspection import IntrospectionServer as IntrospectionServer
from .ros_state import ConditionState as ConditionState
from .ros_state import MonitorState as MonitorState
from .ros_state import RosState as RosState
from .service_state import ServiceState as ServiceState
from .simple_action_state import SimpleActionState as SimpleActionState
from .util import set_preempt_handler as set_preempt_handler

node, condition_state, monitor_state = sys.modules[__name__], ros_state, ros_state
"""Sub-modules of upstream's whose classes are elsewhere."""
_NOETIC = [
    "set_preempt_handler",
    "ActionServerWrapper",
    "IntrospectionClient",
    "IntrospectionServer",
    "SimpleActionState",
    "ServiceState",
    "MonitorState",
    "ConditionState",
]


def __getattr__(name: str) -> Any:
    """Give what depends on the profile (`__all__`) or loads rclpy (`SmachNode`)."""
    if name == "__all__":
        return [*_NOETIC, *(["RosState", "SmachNode"] if settings.ros2 else [])]
    if name == "SmachNode":
        return importlib.import_module("grip_bt.ros.smach_rclpy").SmachNode
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
