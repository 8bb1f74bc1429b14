"""What legacy programs import of ROS 1, over the same connection as `smach_ros`: `rospy`, `roslib`, `actionlib`, `tf`.

Services, topics, actions and frames are those of ROS 2. What ROS 2 has no equal of is kept in the process: parameters.
"""

from __future__ import annotations

import importlib
from functools import partial
from types import ModuleType

from grip_bt.smach_compat._provided import Provided
from grip_bt.smach_compat._settings import settings

from . import _messages

_MODULES = {
    "rospy": ("", ".core", ".exceptions", ".rostime", ".service", ".timer", ".topics", ".client"),
    "roslib": ("", ".packages"),
    "actionlib": ("", ".simple_action_client", ".simple_action_server"),
    "tf": ("", ".listener", ".broadcaster"),
}
"""Module -> the names below it under which programs import it too."""


def _module(name: str) -> ModuleType:
    settings.rospy = True  # from the first import of one of them, and not in programs that import none
    return importlib.import_module(f"{__name__}.{name}")


_PROVIDED = Provided(
    {f"{name}{below}": partial(_module, name) for name, all_below in _MODULES.items() for below in all_below}
    | {"tf.transformations": partial(_module, "transformations")}
)


def begin() -> None:
    """Have them found where no others are."""
    _PROVIDED.begin()
    _messages.begin()


def end() -> None:
    """Have them found no more."""
    _PROVIDED.end()
    _messages.end()
