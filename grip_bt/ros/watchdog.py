"""The run's end of `grip_bt.ros.watchdog_process`: tells it what is under way, to be ended after our death."""

from __future__ import annotations

import json
import os
import select
import subprocess
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress

from grip_bt.base.errors import GripError
from grip_bt.base.files import Closing
from grip_bt.base.interpreter import python_command

REPORT = "GRIP_WATCHDOG_REPORT"
"""Environment variable: number of the file descriptor for the watchdog's report."""
READY = 60.0
"""How long the watchdog may take to come up, where nobody says otherwise [s]: some 2 s on a machine that isn't busy."""
LIMIT = 10.0
"""How long it goes on after the end of the run's process [s]."""
_MARK = "GRIP_RUN_MARK"
"""By this variable processes of a run are found and ended with it; the watchdog has to outlive them."""


class Watchdog(Closing):
    """The process of a watchdog; what is told to it is told before it is done. Nothing here blocks or raises.

    Args:
        domain: the DDS domain; ROS_DOMAIN_ID, else 0, by default.
    """

    def __init__(self, domain: int | None = None):
        number = domain if domain is not None else int(os.environ.get("ROS_DOMAIN_ID") or 0)
        report = os.environ.get(REPORT)
        self._process = subprocess.Popen(
            python_command("-m", "grip_bt.ros.watchdog_process", str(number), str(LIMIT)),
            env={name: value for name, value in os.environ.items() if name != _MARK},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            pass_fds=[int(report)] if report else [],
        )
        assert self._process.stdin is not None
        self._end = self._process.stdin.fileno()
        os.set_blocking(self._end, False)
        self._ready = False

    def wait_ready(self, within: float) -> None:
        """Block until it can do its work, at most `within` [s]. Raises GripError: it can't."""
        assert self._process.stdout is not None
        if not self._ready and select.select([self._process.stdout], [], [], within)[0]:
            self._ready = bool(self._process.stdout.read(1))
        if not self._ready:
            raise GripError(
                "the watchdog, which ends goals when this process is killed, did not start; run `grip doctor`"
            )

    def expect_server(self, action: str) -> None:
        """Have an action's server found before there is a goal."""
        self._tell(expect_server=action)

    def watch_joints(self, part: str, topic: str, joints: Sequence[str], actions: Sequence[str] = ()) -> None:
        """Say which joints tell whether a part is at rest, on which topic they are measured, and which actions move it.

        A goal of any other action has come to rest when its server says that it has ended.
        """
        self._tell(watch_joints=[part, topic, list(joints), list(actions)])

    def goal_sent(self, action: str, goal_id: bytes) -> None:
        """Say that a goal is about to be sent."""
        self._tell(goal_sent=[action, goal_id.hex()])

    def goal_ended(self, goal_id: bytes) -> None:
        """Say that a goal has ended, or is known to its server to be of no use."""
        self._tell(goal_ended=goal_id.hex())

    def close(self) -> None:
        """Let the watchdog end; with goals that no server has answered for it sees to them first."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        with suppress(OSError):
            self._process.stdin.close()
        self._process.stdout.close()
        threading.Thread(target=self._process.wait, name="grip_watchdog", daemon=True).start()  # it may have work to do

    def _tell(self, **line: object) -> None:
        with suppress(OSError, ValueError):  # it has ended, was closed, or is stuck: nothing is lost but it
            os.write(self._end, json.dumps(line).encode() + b"\n")


_shared: dict[int, tuple[Watchdog, int]] = {}
_lock = threading.Lock()


@contextmanager
def shared(domain: int) -> Iterator[Watchdog]:
    """Give the watchdog that all connections of this process to a domain share."""
    with _lock:
        watchdog, users = _shared.get(domain) or (Watchdog(domain), 0)
        _shared[domain] = watchdog, users + 1
    try:
        yield watchdog
    finally:
        with _lock:
            _, users = _shared.pop(domain)
            if users > 1:
                _shared[domain] = watchdog, users - 1
        if users == 1:
            watchdog.close()
