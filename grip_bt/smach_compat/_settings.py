"""What a program may set: the version that this stands in for, how closely, its loggers, its check for shutdown."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType

PROFILES = ("noetic", "ros2")


@dataclass
class Settings:
    """How faithful to be, and to which version: see docs/smach.md.

    `rospy`: number goals' ends as ROS 1 does; set where a program imports `rospy` of `install(rospy=True)`.
    """

    profile: str = "noetic"
    honour_preempt_timeout: bool = False
    unpickle_userdata: bool = False
    rospy: bool = False
    parameters: str = ""

    def update(self, **changes: bool | str) -> None:
        """Change some settings, see docs/smach.md."""
        if unknown := changes.keys() - vars(self).keys():
            raise TypeError(f"no setting {min(unknown)!r} (available: {', '.join(sorted(vars(self)))})")
        if changes.get("profile", self.profile) not in PROFILES:
            raise ValueError(f"unknown profile {changes['profile']!r} (available: {', '.join(PROFILES)})")
        for name, value in changes.items():
            setattr(self, name, value)

    @property
    def ros2(self) -> bool:
        return self.profile == "ros2"


settings = Settings()


configure = settings.update


Logger = Callable[[object], object]


def _printer(level: str) -> Logger:
    return lambda text: sys.stdout.write(f"[{level}] : {text}\n")


loginfo, logwarn, logdebug, logerr = map(_printer, ("  INFO ", "  WARN ", " DEBUG ", " ERROR "))


def quiet(text: object) -> None:
    """Say nothing; a traceback isn't even made for it."""


def is_shutdown() -> bool:
    """Tell whether machines should stop at the next transition; `set_shutdown_check` replaces it."""
    return False


@dataclass
class Hooks:
    """The functions in use."""

    loginfo: Logger
    logwarn: Logger
    logdebug: Logger
    logerr: Logger
    is_shutdown: Callable[[], bool]


hooks = Hooks(loginfo, logwarn, logdebug, logerr, is_shutdown)


def _hook(name: str) -> property:
    return property(
        lambda module: getattr(hooks, name),
        lambda module, function: setattr(hooks, name, function),
        lambda module: delattr(hooks, name),
    )


class SmachModule(ModuleType):
    """The class of the package, whose hooks are read and set by its attributes."""

    loginfo, logwarn, logdebug, logerr, is_shutdown = map(_hook, Hooks.__dataclass_fields__)
