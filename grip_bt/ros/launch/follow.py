"""What the processes of a group print, line by line with their names, as it comes."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from pathlib import Path
from typing import TextIO

from .group import ProcessGroup

LOOK = 0.1
"""How often the logs are looked at [s]."""


class Follower:
    """Copies new lines of the logs of a group.

    Args:
        group: whose.
        names: of its members.
        output: where lines go, as `[name] line`.
    """

    def __init__(self, group: ProcessGroup, names: Sequence[str], output: TextIO):
        self._group, self._names, self._output = group, names, output
        self._read: dict[Path, int] = {}
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._follow, name="grip_follow", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Copy what is left, and end."""
        self._stop.set()
        self._thread.join(2.0)

    def _follow(self) -> None:
        while not self._stop.wait(LOOK):
            self._copy(last=False)
        self._copy(last=True)

    def _copy(self, last: bool) -> None:
        for name in self._names:
            log = self._group.log(name)
            if log is None or not log.is_file():
                continue
            with log.open("rb") as file:
                file.seek(self._read.get(log, 0))
                new = file.read()
            whole = new if last else new[: new.rfind(b"\n") + 1]
            self._read[log] = self._read.get(log, 0) + len(whole)
            for line in whole.decode("utf-8", "replace").splitlines():
                self._output.write(f"[{name}] {line}\n")
        self._output.flush()
