"""Make this package the modules `smach` and `smach_ros` of the process, so that legacy code runs on it unchanged.

Never by default.
"""

from __future__ import annotations

import importlib
import string
import sys
from types import ModuleType

from grip_bt.base.errors import GripError

from ._provided import Provided
from ._settings import Settings, configure

_METHODS = ("capitalize", "count", "find", "index", "lower", "replace", "rfind", "split", "strip", "upper", "zfill")
"""Of strings, which Python 2 had as functions of its module `string` too."""


def _with_submodules(name: str, module: ModuleType) -> dict[str, ModuleType]:
    """Return a package, and what programs import from below it: itself, or a module that is no package."""
    below = {each: value for each, value in vars(module).items() if isinstance(value, ModuleType) and each[0] != "_"}
    ours = {each: value for each, value in below.items() if value.__name__.startswith(module.__name__)}
    found = {each: value for each, value in ours.items() if value is module or not hasattr(value, "__path__")}
    return {name: module, **{f"{name}.{each}": value for each, value in found.items()}}


def _modules(ros: bool = True) -> dict[str, ModuleType]:
    modules = _with_submodules("smach", sys.modules[__package__])
    if ros:
        modules |= _with_submodules("smach_ros", importlib.import_module("grip_bt.smach_compat.smach_ros"))
    return modules


def install(*, ros: bool = True, rospy: bool = False, **changes: bool | str) -> None:
    """Let `import smach`, `import smach_ros` and their modules find this package; harmless when it was done before.

    Args:
        ros: whether `smach_ros` is meant too, and `smach_msgs`, where no other is installed.
        rospy: whether `rospy`, `roslib`, `actionlib` and `tf` of ROS 1 are too, over ROS 2, where no others are:
            neither installed nor put there by a unit test.
        **changes: settings, see `configure`.

    Raises:
        GripError: another `smach` or `smach_ros` has been imported already; code that has it would go on with it.
    """
    modules = _modules(ros)
    for name in ("smach", "smach_ros"):
        present = sys.modules.get(name)
        if present is not None and present is not modules.get(name, present):
            raise GripError(
                f"{name} is imported already, from {getattr(present, '__file__', 'somewhere')}; "
                "call install() before anything imports it"
            )
    configure(**changes)
    sys.modules.update(modules)
    for name in _METHODS:
        setattr(string, name, getattr(str, name))
    if ros:
        smach_msgs().begin()
    if rospy:
        importlib.import_module("grip_bt.smach_compat.ros1").begin()


def smach_msgs() -> Provided:
    """Return what provides `smach_msgs`; its messages are ROS's."""
    provided: Provided = importlib.import_module("grip_bt.smach_compat.smach_ros._connection").PROVIDED
    return provided


def uninstall() -> None:
    """Undo `install`, and put the settings back; who has imported the names keeps them."""
    for name, module in _modules().items():
        if sys.modules.get(name) is module:
            del sys.modules[name]
    for name in _METHODS:
        vars(string).pop(name, None)
    smach_msgs().end()
    if "grip_bt.smach_compat.ros1" in sys.modules:
        sys.modules["grip_bt.smach_compat.ros1"].end()
    configure(**vars(Settings()))
