"""Where smach's messages go: four functions, kept as attributes of the package so that a program may replace them."""

from __future__ import annotations

from grip_bt.smach_compat._settings import Logger, hooks
from grip_bt.smach_compat._settings import logdebug as logdebug
from grip_bt.smach_compat._settings import logerr as logerr
from grip_bt.smach_compat._settings import loginfo as loginfo
from grip_bt.smach_compat._settings import logwarn as logwarn


def set_loggers(info: Logger, warn: Logger, debug: Logger, error: Logger) -> None:
    """Replace the four functions; mind the order, `debug` comes before `error`."""
    hooks.loginfo, hooks.logwarn, hooks.logdebug, hooks.logerr = info, warn, debug, error
