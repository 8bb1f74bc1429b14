"""What ROS tests hold in their hands: servers in other processes, operations that must end, processes that must go."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from contextlib import ExitStack, contextmanager
from pathlib import Path

from patience import PATIENCE, until
from server_process import serving

EXAMPLE = Path(__file__).parents[2] / "examples" / "components" / "antipodal_grasps"
DATA = Path(__file__).parent / "data"


@contextmanager
def servers(domain: int):
    """Give a function that starts a program of `data/` in a process that isn't ours to watch, and waits for its word.

    It takes the file's name, arguments, and prefixes with further packages; all are killed at the end.
    """
    with ExitStack() as stack:

        def start(file: str, *arguments: str, overlays=()) -> subprocess.Popen:
            return stack.enter_context(serving(DATA / file, *arguments, domain=domain, overlays=overlays))

        yield start


def stands(states, names):
    """Wait until joints are measured to stand still for a while, by their stamps, and return where."""
    before, now = ended(states.fresh(names)), ended(states.fresh(names))
    deadline = time.monotonic() + PATIENCE
    while now.time - before.time < 0.5:
        assert time.monotonic() < deadline, "the joints don't stand"
        now = ended(states.fresh(names))
        if abs(now.position - before.position).max() > 1e-4:
            before = now
    return now.position


def ended(operation, within: float = PATIENCE):
    """Return the result of an operation, or raise its error; it must end `within` [s]."""
    assert operation.wait(within), "the operation hangs"
    return operation.result()


class Deadline:
    """Stands for `threading.Timer`: time is over when the test says so."""

    def __init__(self, seconds, end):
        self.seconds, self.over = seconds, end
        Deadline.last = self

    def start(self):
        """Begin to wait; nothing happens by itself."""

    cancel = start


def session_of(pid: int) -> list[int]:
    """Return the processes of the session that `pid` leads, zombies included."""
    found = []
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit():
            try:
                fields = (folder / "stat").read_text().rpartition(")")[2].split()
            except OSError:
                continue
            if int(fields[3]) == pid:
                found.append(int(folder.name))
    return found


def gone(pid: int) -> bool:
    """Wait until no process of a session is left; it must end before what it runs would end by itself."""
    until(lambda: not session_of(pid), f"left: {session_of(pid)}")
    return True


def kill(pid: int) -> None:
    os.kill(pid, signal.SIGKILL)
