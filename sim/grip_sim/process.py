"""The operating system's side of a simulator: a child process, what it prints, and its certain end."""

from __future__ import annotations

import socket
import subprocess
import threading
from collections import deque

from grip_bt.base.interpreter import python_command

LINES = 40
"""How many of the last lines are kept for the message about its end."""


class SimProcess:
    """A child process that runs `python -m grip_sim`.

    It ends by itself when the other end of its connection is gone, also when our process was killed.

    Args:
        connection: its end of a socket pair; may be closed here afterwards.
        hold: file descriptor over which somebody else may have the robot hold; None for nobody.
    """

    def __init__(self, connection: socket.socket, hold: int | None = None):
        descriptors = [connection.fileno(), *([] if hold is None else [hold])]
        command = python_command("-m", "grip_sim", *map(str, descriptors))
        # What it prints is kept from our standard output, which may carry a protocol.
        self._process = subprocess.Popen(
            command,
            pass_fds=descriptors,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        self._said: deque[bytes] = deque(maxlen=LINES)
        self._listener = threading.Thread(target=self._listen, name="grip_sim_output", daemon=True)
        self._listener.start()

    @property
    def pid(self) -> int:
        """The process id."""
        return self._process.pid

    def end(self, patience: float) -> int:
        """Wait for its end, kill it after `patience` [s], and return its exit status."""
        try:
            return self._process.wait(patience)
        except subprocess.TimeoutExpired:
            self._process.kill()
            return self._process.wait()

    def last_words(self) -> str:
        """Return what it printed last, at most 2000 characters."""
        self._listener.join(1.0)  # after its end this takes no time
        return b"".join(self._said).decode(errors="replace").strip()[-2000:]

    def close(self) -> None:
        """Give back the pipe; after the end."""
        self._listener.join(1.0)
        if not self._listener.is_alive() and self._process.stdout is not None:
            self._process.stdout.close()

    def _listen(self) -> None:
        assert self._process.stdout is not None
        self._said.extend(self._process.stdout)
