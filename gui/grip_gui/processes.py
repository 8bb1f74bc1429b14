"""Ends a process with everything that it started, also what has moved to other process groups or lost its parent.

A run starts simulators and component servers in groups of their own. They inherit its environment, so a mark in the
environment finds them all (as build servers do), however they were started and whoever their parent is by now.
"""

from __future__ import annotations

import asyncio
import os
import signal
from pathlib import Path

MARK = "GRIP_RUN_MARK"
"""Environment variable that all processes of one run share."""
GRACE = 1.0
"""How long a left-over process may take to end after SIGTERM [s]."""


def marked(mark: str) -> list[int]:
    """Return the ids of all living processes of this user that carry the mark; never this one."""
    needle = f"{MARK}={mark}".encode()
    found = []
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit() or int(entry.name) == os.getpid():
            continue
        try:
            environment = (entry / "environ").read_bytes()
        except OSError:
            continue  # it has ended, or belongs to somebody else
        if needle in environment.split(b"\0"):
            found.append(int(entry.name))
    return found


async def end_marked(mark: str, group: int | None = None) -> None:
    """End all processes with the mark: those in `group` at once, the others with a chance to clean up.

    Args:
        mark: value of the environment variable `MARK`.
        group: a process group to kill first, None for none.
    """
    if group is not None:
        _signal_group(group, signal.SIGKILL)
    _signal_all(marked(mark), signal.SIGTERM)
    loop = asyncio.get_running_loop()
    deadline = loop.time() + GRACE
    while (left := marked(mark)) and loop.time() < deadline:
        await asyncio.sleep(0.02)
    _signal_all(left, signal.SIGKILL)


def _signal_all(pids: list[int], number: signal.Signals) -> None:
    for pid in pids:
        try:
            os.kill(pid, number)
        except ProcessLookupError:
            continue


def _signal_group(group: int, number: signal.Signals) -> None:
    try:
        os.killpg(group, number)
    except ProcessLookupError:
        return
