"""The `smach_ros` library again: states that use ROS, and machines on the network.

Signatures of ROS 1 (no node) and of ROS 2 (a node first) are both taken. It runs on rclpy,
which importing it doesn't load. `use` gives it another connection.
"""

from __future__ import annotations

import importlib
import sys
from typing import Any

from grip_bt.smach_compat._settings import hooks, settings

from . import action_server_wrapper as action_server_wrapper
from . import introspection as introspection
from . import ros_state as ros_state
from . import service_state as service_state
from . import simple_action_state as simple_action_state
from ._connection import ros
from ._connection import use as use
from .action_server_wrapper import ActionServerWrapper as ActionServerWrapper
from .introspection import IntrospectionClient as IntrospectionClient
from .introspection import IntrospectionServer as IntrospectionServer
from .ros_state import ConditionState as ConditionState
from .ros_state import MonitorState as MonitorState
from .ros_state import RosState as RosState
from .service_state import ServiceState as ServiceState
from .simple_action_state import SimpleActionState as SimpleActionState

node = util = sys.modules[__name__]
condition_state = monitor_state = ros_state
"""Sub-modules of upstream's whose names are elsewhere."""
POLL = 1.0
"""How often a machine that was asked to stop is looked at [s]."""
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


def set_preempt_handler(sc: Any) -> None:
    """Ask a container to stop when ROS is asked to shut down, and wait until it has stopped."""

    def handler() -> None:
        sc.request_preempt()
        running = getattr(sc, "is_running", lambda: False)  # a Concurrence has none, and upstream fails there
        while running():
            hooks.loginfo("Received a shutdown request: asked the state machine to stop, waiting for it.")
            ros().sleep(POLL)

    ros().on_shutdown(handler)
