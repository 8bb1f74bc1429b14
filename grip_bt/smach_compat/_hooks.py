"""What a program may replace in the package `smach`: its four loggers and the check for shutdown.

Legacy code sets them on the package (`smach.loginfo = f`), so the package's attributes and these are the same: each
module looks them up here at each use, and none has to import the package that imports it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType

Logger = Callable[[object], object]


def loginfo(msg: object) -> None:
    """Print an information."""
    sys.stdout.write(f"[  INFO ] : {msg}\n")


def logwarn(msg: object) -> None:
    """Print a warning."""
    sys.stdout.write(f"[  WARN ] : {msg}\n")


def logdebug(msg: object) -> None:
    """Print a detail for debugging."""
    sys.stdout.write(f"[ DEBUG ] : {msg}\n")


def logerr(msg: object) -> None:
    """Print an error."""
    sys.stdout.write(f"[ ERROR ] : {msg}\n")


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
