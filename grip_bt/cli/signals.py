"""Signals that end a command in order: Ctrl-C, SIGTERM, and SIGHUP of a terminal that has gone."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable
from contextlib import suppress


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
        let_go_of_terminal()
        stop()

    if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        signal.signal(signal.SIGHUP, hung_up)


def let_go_of_terminal() -> None:
    """Have standard streams that are terminals be the null device from now on."""
    for stream in (sys.stdin, sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError):
            number = stream.fileno()
            if os.isatty(number) or _is_dead(number):
                null = os.open(os.devnull, os.O_RDWR)
                os.dup2(null, number)
                os.close(null)


def _is_dead(number: int) -> bool:
    """Tell whether a file descriptor is of a terminal that has gone, of which `isatty` says no."""
    try:
        device = os.fstat(number).st_rdev
    except OSError:
        return True
    return bool(device) and os.major(device) in _TERMINALS


_TERMINALS = (4, 5, *range(136, 144))
"""Major numbers of devices that are terminals, https://www.kernel.org/doc/Documentation/admin-guide/devices.txt."""
