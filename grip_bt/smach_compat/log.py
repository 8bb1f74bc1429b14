"""Where smach's messages go: four functions, kept as attributes of the package so that a program may replace them.

Internal code looks them up late (`smach.loginfo(...)`), so that a replacement takes effect at once.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from grip_bt import smach_compat as smach

Logger = Callable[[Any], Any]


def loginfo(msg: Any) -> None:
    """Print an information."""
    sys.stdout.write(f"[  INFO ] : {msg}\n")


def logwarn(msg: Any) -> None:
    """Print a warning."""
    sys.stdout.write(f"[  WARN ] : {msg}\n")


def logdebug(msg: Any) -> None:
    """Print a detail for debugging."""
    sys.stdout.write(f"[ DEBUG ] : {msg}\n")


def logerr(msg: Any) -> None:
    """Print an error."""
    sys.stdout.write(f"[ ERROR ] : {msg}\n")


def silent(msg: Any) -> None:
    """Say nothing; a machine that logs by this doesn't even compose the message."""


def set_loggers(info: Logger, warn: Logger, debug: Logger, error: Logger) -> None:
    """Replace the four functions; mind the order, `debug` comes before `error`."""
    vars(smach).update(loginfo=info, logwarn=warn, logdebug=debug, logerr=error)
