"""Trials, each in a process of its own that is watched over, several at once."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from grip_bt.app.runs.execute import RunOptions
from grip_bt.app.runs.mocks import scripted
from grip_bt.app.runs.supervisor import Supervisor

from .file import Campaign
from .judging import judged

Trial = tuple[str, int]
Told = Callable[[Mapping[str, Any]], None]
WAKE = 0.2
"""How often who waits for the trials looks up [s]: a Ctrl-C that another thread is given by the system wakes nobody."""


class Trials:
    """Runs trials of a campaign.

    Args:
        campaign: checked.
        journal: where their runs are written.
        ended: called with each row, one at a time.
        watchdog: how long one tick may take [s] before a trial ends as an error.
    """

    def __init__(self, campaign: Campaign, journal: Path, ended: Told, watchdog: float = 10.0):
        self._campaign, self._journal, self._ended, self._watchdog = campaign, journal, ended, watchdog
        self._lock = threading.Lock()
        self._stopped = threading.Event()
        self._under_way: set[Supervisor] = set()
        self._error: BaseException | None = None

    def run(self, trials: Iterable[Trial], workers: int = 1) -> None:
        """Run them all, `workers` at a time; returns when they have ended, or after `stop`.

        Raises:
            Exception: what `ended` has raised; the other trials are stopped then.
        """
        waiting: queue.SimpleQueue[Trial] = queue.SimpleQueue()
        for trial in trials:
            waiting.put(trial)
        threads = [threading.Thread(target=self._work, args=(waiting,), daemon=True) for _ in range(workers)]
        for thread in threads:
            thread.start()
        for thread in threads:
            while thread.is_alive():
                thread.join(WAKE)
        if self._error is not None:
            raise self._error

    def stop(self) -> None:
        """Stop the trials under way, and begin no other. They leave no row. May be called from a signal handler."""
        self._stopped.set()
        for supervisor in list(self._under_way):
            supervisor.stop()

    def _work(self, waiting: queue.SimpleQueue[Trial]) -> None:
        while not self._stopped.is_set():
            try:
                variant, seed = waiting.get_nowait()
            except queue.Empty:
                return
            try:
                self._trial(variant, seed)
            except BaseException as error:  # noqa: BLE001 - raised by `run`, in the thread that asked
                self._error = self._error or error
                self.stop()

    def _trial(self, variant: str, seed: int) -> None:
        began = time.monotonic()
        started: list[Mapping[str, Any]] = []

        def told(event: Mapping[str, Any]) -> None:
            if event["event"] == "started":
                started.append(event)

        said = self._campaign.file
        task = self._campaign.task(variant)
        supervisor = Supervisor(str(task), self._options(variant, seed), told, self._watchdog, own_input=False)
        late = threading.Event()

        def too_late() -> None:
            late.set()
            supervisor.stop()

        supervisor.start()
        timer = threading.Timer(said.timeout, too_late)
        timer.daemon = True
        timer.start()
        with self._lock:
            self._under_way.add(supervisor)
        if self._stopped.is_set():
            supervisor.stop()
        end = supervisor.wait()
        timer.cancel()
        with self._lock:
            self._under_way.discard(supervisor)
        if self._stopped.is_set() and not late.is_set():
            return
        if late.is_set() and end.get("status") == "stopped":
            end |= {"status": "timed_out", "message": f"not done after {said.timeout:g} s of wall time"}
        elif end["event"] == "failed":
            end |= {"status": "error"}
        row = judged(self._campaign, end, time.monotonic() - began, started[0] if started else None)
        with self._lock:
            self._ended({"variant": variant, "seed": seed, **row})

    def _options(self, variant: str, seed: int) -> RunOptions:
        said, settings = self._campaign.file, self._campaign.file.variants[variant]
        return RunOptions(
            target=settings.form,
            robot=said.robot,
            seed=seed,
            data=settings.set,
            mocks=scripted(settings.mocks),
            journal=self._journal,
            watchdog=self._watchdog,
        )
