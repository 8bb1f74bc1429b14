"""Which ROS this process uses, and what differs between ROS 1 and ROS 2 in durations, messages and signatures.

It is what was given, else rclpy. The first state or server that needs it connects, and not the import of this package.
"""

from __future__ import annotations

import builtins
import dis
import functools
import importlib
import sys
import threading
from collections.abc import Callable
from functools import partial
from types import CodeType, FrameType, ModuleType
from typing import Any

from grip_bt.smach_compat import _settings
from grip_bt.smach_compat._provided import Provided
from grip_bt.smach_compat._settings import hooks, settings
from grip_bt.smach_compat.log import set_loggers
from grip_bt.smach_compat.util import set_shutdown_check

from ._port import STATUS, Ros

_ADAPTER = "grip_bt.ros.smach_rclpy"
_lock = threading.Lock()
_ros: Ros | None = None


def use(ros: Ros | None) -> None:
    """Use this adapter from now on; None to choose again at the next need.

    Args:
        ros: an adapter, for instance `grip_bt.ros.smach_rclpy.connect(domain_id=7)`.
    """
    global _ros
    with _lock:
        if _ros is not None:
            _remove_hooks(_ros)
        _ros = ros
        if ros is not None:
            _install_hooks(ros)


def ros() -> Ros:
    """Return the process's ROS, connecting to it at the first call.

    Raises:
        MissingPartError: there is no rclpy; the message says what to install.
    """
    global _ros
    with _lock:
        if _ros is None:
            # By name: this room is below grip_bt.ros, and importing it must not load ROS.
            _ros = importlib.import_module(_ADAPTER).connect()
            _install_hooks(_ros)
        return _ros


def _install_hooks(ros: Ros) -> None:
    """Log by ROS and stop machines with it, as importing smach_ros does upstream; what the program has set stays."""
    if ros.loggers and all(
        getattr(hooks, name) is getattr(_settings, name) for name in ("loginfo", "logwarn", "logdebug", "logerr")
    ):
        set_loggers(*ros.loggers)
    if hooks.is_shutdown is _settings.is_shutdown:
        set_shutdown_check(ros.is_shutdown)


def _remove_hooks(ros: Ros) -> None:
    """Take back what a connection that is used no more has set; one that is closed would end every machine."""
    if hooks.is_shutdown == ros.is_shutdown:
        set_shutdown_check(_settings.is_shutdown)
    if ros.loggers and hooks.loginfo == ros.loggers[0]:
        set_loggers(_settings.loginfo, _settings.logwarn, _settings.logdebug, _settings.logerr)


def seconds(duration: Any) -> float:
    """Return a duration in seconds: a number, a `rospy.Duration` or an rclpy one."""
    if hasattr(duration, "to_sec"):
        return float(duration.to_sec())
    if hasattr(duration, "nanoseconds"):
        return float(duration.nanoseconds) / 1e9
    return float(duration)


def status_of(ending: str, status: int) -> int:
    """Return the number of a goal's end: that of ROS 1 where the process has its modules."""
    return STATUS[ending] if settings.rospy else status


def stands_in(value: object) -> bool:
    """Tell whether a value stands for what isn't here, as in a dry run: nothing is known of it."""
    return hasattr(type(value), "_stand_in_name")  # the class is of a room above


def fields(message: Any) -> tuple[str, ...]:
    return tuple(message.get_fields_and_field_types())


def is_node(thing: object) -> bool:
    return hasattr(thing, "create_publisher") and hasattr(thing, "get_name")


def with_optional_node(init: Callable[..., None]) -> Callable[..., None]:
    """Let an `__init__` be called with a node first, or as `node=`; it is kept as `_node`."""

    @functools.wraps(init)
    def taking(self: Any, *args: Any, **kwargs: Any) -> None:
        node = kwargs.pop("node", None)
        named = bool(args) and stands_in(args[0]) and isinstance([*args, str][1], type)  # unknown, and before a type
        if args and is_node(args[0]) and not named:
            node, *args = args  # type: ignore[assignment]
        self._node = node
        init(self, *args, **kwargs)

    return taking


_MESSAGES = {f"SmachContainer{name}": name for name in ("Status", "Structure", "InitialStatusCmd")}


class _Messages(ModuleType):
    __path__: list[str] = []

    def __getattr__(self, name: str) -> Any:
        if name == "__all__":
            return sorted(_MESSAGES.keys() & wanted_names(sys._getframe(1)))
        if name in _MESSAGES:
            return getattr(ros().introspection(), _MESSAGES[name])
        raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")


def wanted_names(frame: FrameType | None) -> set[str]:
    """Return the names that the module which imports uses and nobody has given it: what a star import has to."""
    while frame is not None and (frame.f_code.co_name != "<module>" or frame.f_globals["__name__"] == __name__):
        frame = frame.f_back
    if frame is None:
        return set()
    return {name for name in names_used(frame.f_code) - {*vars(builtins), *frame.f_globals} if name[0] != "_"}


@functools.lru_cache
def names_used(code: CodeType) -> set[str]:
    """Return the names of its module that a module's code, and what is defined in it, goes by."""
    todo, names = [code], set[str]()
    while todo:
        code = todo.pop()
        names.update(i.argval for i in dis.get_instructions(code) if i.opname in ("LOAD_NAME", "LOAD_GLOBAL"))
        todo += [each for each in code.co_consts if isinstance(each, CodeType)]
    return names


PROVIDED = Provided({name: partial(_Messages, name) for name in ("smach_msgs", "smach_msgs.msg")})
"""Ends before the messages themselves are loaded."""
