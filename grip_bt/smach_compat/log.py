"""Where smach's messages go: four functions, kept as attributes of the package so that a program may replace them."""

from __future__ import annotations

from ._hooks import Logger, hooks
from ._hooks import logdebug as logdebug
from ._hooks import logerr as logerr
from ._hooks import loginfo as loginfo
from ._hooks import logwarn as logwarn


def set_loggers(info: Logger, warn: Logger, debug: Logger, error: Logger) -> None:
    """Replace the four functions; mind the order, `debug` comes before `error`."""
    hooks.loginfo, hooks.logwarn, hooks.logdebug, hooks.logerr = info, warn, debug, error
