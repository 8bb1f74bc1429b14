"""Runs one command and sees to its death: a script of its own, started by `grip_bt.ros.process`; it needs no GRIP.

It leads a session and puts the command into a process group. When its standard input closes, because we asked
for it or because we died, however suddenly, it ends the group: SIGINT, SIGTERM, SIGKILL. When the command ends by
itself, what it left behind is ended likewise. Processes that left the group are found as descendants, since orphans are
handed to it. Its exit status is the command's (128 + number for a signal).
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

_PR_SET_PDEATHSIG, _PR_SET_CHILD_SUBREAPER = 1, 36
_STEPS = ((signal.SIGINT, 1.2), (signal.SIGTERM, 0.6), (signal.SIGKILL, 0.6))


def main(command: list[str]) -> int:
    """Run the command; return its exit status."""
    prctl = ctypes.CDLL(None).prctl
    prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    wake = _wake_on_signals()
    try:
        child = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            process_group=0,
            preexec_fn=lambda: prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0),
        )
    except OSError as error:
        sys.stderr.write(f"{command[0]}: {error.strerror}\n")
        return 127
    status: int | None = None
    while status is None:
        ready, _, _ = select.select([0, wake], [], [], 1.0)
        status, _ = _reap(child.pid)
        if 0 in ready and not os.read(0, 1):
            break
        if wake in ready and signal.SIGTERM in os.read(wake, 64):
            break
    status = _end_all(child.pid, status)
    child.returncode = 0  # reaped here, not by subprocess
    return 128 + os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)


def _wake_on_signals() -> int:
    """Return a file descriptor that becomes readable on SIGCHLD and on signals that ask us to end."""
    reader, writer = os.pipe2(os.O_NONBLOCK | os.O_CLOEXEC)
    for number in (signal.SIGCHLD, signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        signal.signal(number, lambda *_: None)
    signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    return reader


def _reap(leader: int) -> tuple[int | None, bool]:
    """Collect every child that has ended; return the leader's status if it was among them, and whether any is left.

    One that has ended is left as long as one of its threads lives.
    """
    found = None
    try:
        while (ended := os.waitpid(-1, os.WNOHANG))[0]:
            if ended[0] == leader:
                found = ended[1]
    except ChildProcessError:
        return found, False
    return found, True


def _end_all(leader: int, status: int | None) -> int:
    """End the group and every other descendant, more and more firmly; return the leader's status."""
    for number, patience in _STEPS:
        deadline = time.monotonic() + patience
        _signal(leader, number)
        while time.monotonic() < deadline:
            ended, left = _reap(leader)
            status = ended if ended is not None else status
            if not left:
                return status if status is not None else 0
            time.sleep(0.01)
    return status if status is not None else signal.SIGKILL


def _signal(leader: int, number: int) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(leader, number)
    for pid in _descendants():
        with contextlib.suppress(ProcessLookupError, PermissionError):
            if os.getpgid(pid) != leader:
                os.kill(pid, number)


def _descendants() -> set[int]:
    """Return every process below this one that hasn't ended."""
    parents = {}
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit():
            with contextlib.suppress(OSError, ValueError):
                state, parent = (folder / "stat").read_text().rpartition(")")[2].split()[:2]
                if state not in "ZX":
                    parents[int(folder.name)] = int(parent)
    found, todo = set(), {os.getpid()}
    while todo:
        todo = {pid for pid, parent in parents.items() if parent in todo and pid not in found}
        found |= todo
    return found


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
