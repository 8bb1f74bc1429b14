"""Signals that end a command, and terminals that have gone."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable
from contextlib import suppress

from .terminal import to_nowhere


def on_stop(stop: Callable[[], object]) -> None:
    """Call `stop()` at each of them; see `on_hang_up`."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop())
    on_hang_up(stop)


def on_hang_up(stop: Callable[[], object]) -> None:
    """Call `stop()` when the terminal has gone; with `nohup`, which has SIGHUP ignored, that stays so.

    Nothing more is written to the terminal then: what is printed goes nowhere, and raises nothing.
    """

    def hung_up(*_: object) -> None:
        for stream in (sys.stdin, sys.stdout, sys.stderr):
            with suppress(OSError, ValueError, AttributeError):
                if os.isatty(stream.fileno()) or _is_dead(stream.fileno()):
                    to_nowhere(stream)
        stop()

    if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        signal.signal(signal.SIGHUP, hung_up)


def _is_dead(number: int) -> bool:
    """Tell whether a file descriptor is of a terminal that has gone, of which `isatty` says no."""
    try:
        device = os.fstat(number).st_rdev
    except OSError:
        return True
    return bool(device) and os.major(device) in _TERMINALS


_TERMINALS = (4, 5, *range(136, 144))
"""Major numbers of devices that are terminals, https://www.kernel.org/doc/Documentation/admin-guide/devices.txt."""
