"""The `smach` library again: the same names, the same sub-modules, the same results, on Python 3 and without ROS.

Legacy machines run on it unchanged: `install()` makes this package the module `smach` of the process. What differs from
upstream, noetic 2.5.x, on purpose is listed in docs/smach.md, each with its test.
"""

from .container import Container
from .exceptions import (
    InvalidConstructionError,
    InvalidStateError,
    InvalidTransitionError,
    InvalidUserCodeError,
    SmachError,
)
from .log import logdebug, logerr, loginfo, logwarn, set_loggers
from .state import CBState, State
from .state_machine import StateMachine
from .user_data import Remapper, UserData
from .util import CBInterface, cb_interface, has_smach_interface, is_shutdown, set_shutdown_check

__all__ = [
    "CBInterface",
    "CBState",
    "Container",
    "InvalidConstructionError",
    "InvalidStateError",
    "InvalidTransitionError",
    "InvalidUserCodeError",
    "Remapper",
    "SmachError",
    "State",
    "StateMachine",
    "UserData",
    "cb_interface",
    "has_smach_interface",
    "is_shutdown",
    "logdebug",
    "logerr",
    "loginfo",
    "logwarn",
    "set_loggers",
    "set_shutdown_check",
]
