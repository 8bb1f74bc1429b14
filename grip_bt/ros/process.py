"""Somebody else's process: what runs it, started in a group of its own, logged, and certain to die with us.

A process reaper (`grip_bt.ros.process_reaper`) stands between: it ends the whole group when we ask
for it and when we vanish.
"""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from grip_bt.base.operation import Operation
from grip_bt.ros import process_reaper
from grip_bt.task.catalog.start import Start

_PATIENCE = 3.5
"""How long the process reaper may take to end the group [s]."""


class Process:
    """A command that runs until it ends or is stopped.

    Args:
        log: file that takes what it prints; its folder is made.
        again: says whether it is started again after it ended by itself.
    """

    def __init__(
        self,
        name: str,
        command: Sequence[str],
        folder: Path,
        env: Mapping[str, str],
        log: Path,
        again: Start | None = None,
    ):
        self.name, self.command, self.log = name, tuple(command), log
        self._folder, self._env, self._again, self._starts = folder, dict(env), again, 0
        self._lock, self._stopping = threading.Lock(), threading.Event()
        self._broke: list[Callable[[], object]] = []
        log.parent.mkdir(parents=True, exist_ok=True)
        self._start()
        self._end: Operation[int] = Operation()
        threading.Thread(target=self._watch, name=f"process-{name}", daemon=True).start()

    def _start(self) -> None:
        with self.log.open("ab" if self._starts else "wb") as output:
            self._popen = subprocess.Popen(
                [sys.executable, "-I", "-S", str(Path(process_reaper.__file__).resolve()), *self.command],
                cwd=self._folder,
                env=self._env,
                stdin=subprocess.PIPE,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        self._starts += 1

    @property
    def alive(self) -> bool:
        """Whether it runs or is about to be started again."""
        return not self._end.done()

    @property
    def pid(self) -> int:
        """The process id of the process reaper; it leads the session of everything below."""
        return self._popen.pid

    @property
    def returncode(self) -> int | None:
        """The exit status (128 + number for a signal), None while it runs."""
        return self._popen.poll()

    def when_broken(self, callback: Callable[[], object]) -> None:
        """Call `callback()`, from another thread, each time that it ended by itself and will be started again."""
        self._broke.append(callback)

    def when_ended(self, callback: Callable[[], object]) -> None:
        """Call `callback()` when it has ended for good, from another thread; at once if it has."""
        self._end.add_done_callback(callback)

    def stop(self) -> None:
        """End the whole group and wait for it, at most some seconds; harmless when it has ended."""
        self.ask_to_stop()
        if not self._end.wait(_PATIENCE):
            self._popen.kill()  # the command dies with the process reaper
            self._end.wait(1.0)

    def ask_to_stop(self) -> None:
        """Begin to end the group, without waiting."""
        with self._lock:
            self._stopping.set()
            self._end_group()

    def _end_group(self) -> None:
        assert self._popen.stdin is not None
        self._popen.stdin.close()

    def log_tail(self, lines: int = 12) -> str:
        """Return the last lines that it printed."""
        try:
            text = self.log.read_bytes()[-8192:].decode("utf-8", "replace")
        except OSError:
            return ""
        return "\n".join(text.strip().splitlines()[-lines:])

    def describe_end(self) -> str:
        """Return how it ended and what it printed last, for an error message."""
        tail = self.log_tail()
        said = f"; its last output ({self.log}):\n{tail}" if tail else f"; it printed nothing ({self.log})"
        again = f"; start {self._starts + 1} follows" if self.alive else ""
        often = f" after {self._starts} starts" if self._starts > 1 and not again else ""
        return f"the process {self.name!r} ended with status {self.returncode}{often}{again}{said}"

    def _watch(self) -> None:
        status = self._popen.wait()
        self._end_group()
        again = self._again
        while again is not None and again.again(status != 0, self._starts) and not self._stopping.is_set():
            for callback in self._broke:
                callback()
            self._stopping.wait(again.restart_delay)
            with self._lock:
                if self._stopping.is_set():
                    break
                self._start()
            status = self._popen.wait()
            self._end_group()
        self._end.succeed(status)


def stop_all(processes: Sequence[Process]) -> None:
    """End several processes at once."""
    for process in processes:
        process.ask_to_stop()
    for process in processes:
        process.stop()
