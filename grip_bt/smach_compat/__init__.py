"""The `smach` library again: the same names, the same sub-modules, the same results, on Python 3 and without ROS.

Legacy machines run on it unchanged: `install()` makes this package the module `smach` of the process. What differs from
upstream, noetic 2.5.x, on purpose is listed in docs/compatibility.md, each with its test.
"""

import sys
from typing import TYPE_CHECKING

from grip_bt.smach_compat._settings import SmachModule

from . import (
    concurrence,
    container,
    exceptions,
    iterator,
    log,
    sequence,
    state,
    state_machine,
    user_data,
    util,
)
from ._install import install as install
from ._install import uninstall as uninstall
from ._settings import configure as configure
from .concurrence import Concurrence
from .container import Container
from .exceptions import (
    InvalidConstructionError,
    InvalidStateError,
    InvalidTransitionError,
    InvalidUserCodeError,
    SmachError,
)
from .iterator import Iterator
from .log import set_loggers
from .sequence import Sequence
from .state import CBState, State
from .state_machine import StateMachine
from .user_data import Remapper, UserData
from .util import CBInterface, cb_interface, has_smach_interface, set_shutdown_check

if TYPE_CHECKING:  # when the package runs, its class has them: what is set on the package takes effect everywhere
    from grip_bt.smach_compat._settings import is_shutdown, logdebug, logerr, loginfo, logwarn

# What `from smach import *` gives upstream, and SmachError; `install`, `uninstall` and `configure` are ours.
__all__ = [
    "CBInterface",
    "CBState",
    "Concurrence",
    "Container",
    "InvalidConstructionError",
    "InvalidStateError",
    "InvalidTransitionError",
    "InvalidUserCodeError",
    "Iterator",
    "Remapper",
    "Sequence",
    "SmachError",
    "State",
    "StateMachine",
    "UserData",
    "cb_interface",
    "concurrence",
    "container",
    "exceptions",
    "has_smach_interface",
    "is_shutdown",
    "iterator",
    "log",
    "logdebug",
    "logerr",
    "loginfo",
    "logwarn",
    "sequence",
    "set_loggers",
    "set_shutdown_check",
    "state",
    "state_machine",
    "user_data",
    "util",
]

sys.modules[__name__].__class__ = SmachModule
