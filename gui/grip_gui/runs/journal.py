"""Runs and their events for the page, out of the project's journal: the live view and the replay read the same."""

from __future__ import annotations

import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

from grip_bt.base.errors import GripError, UnknownNameError
from grip_bt.runtime import Event, Journal, JournalError, JournalReader, RunLog
from grip_bt.runtime import RunRecord as JournalRecord
from grip_gui.runs.values import unkept_view, value_view
from grip_gui.wire.runs import RunEvent, RunRecord, ValueView

LISTED = 100
"""Most runs that are offered."""


class JournalRuns:
    """The runs of a journal file; as long as there is no file there are no runs. Safe to use from several threads.

    Args:
        file: the journal.
        folder: the project folder, to which the paths of tasks are made relative.
    """

    def __init__(self, file: Path, folder: Path):
        self.file, self._folder = file, folder
        self._lock = threading.Lock()
        self._opened: JournalReader | None = None
        self._damage: dict[tuple[str, float | None], str] = {}

    def runs(self) -> list[RunRecord]:
        """Return the latest runs, newest first."""
        reader, found = self._reader(), []
        for record in reader.runs()[:LISTED] if reader else ():
            key = (record.id, record.ended)
            if reader and record.status != "running" and key not in self._damage:  # looked for once
                self._damage[key] = reader.damage_of(record.id)
            found.append(self._wire(record).model_copy(update={"damage": self._damage.get(key, "")}))
        return found

    def run(self, run: str) -> RunRecord:
        """Return one run.

        Raises:
            UnknownNameError: it isn't there.
        """
        return self._wire(self._find(run))

    def task_text(self, run: str) -> str:
        """Return the task file as it was when the run started."""
        return self._find(run).task_text

    def events(self, run: str, from_seq: int, limit: int) -> list[RunEvent]:
        """Return at most `limit` events from `from_seq` on, in order."""
        reader = self._reader()
        found = [] if reader is None else reader.events(run, from_seq - 1, limit)
        return [RunEvent.model_validate(event) for event in found]  # without the outcomes' meaning: pages know the task

    def value(self, run: str, seq: int) -> ValueView:
        """Return what the write with this number wrote, for looking at."""
        reader, event = self._write_of(run, seq)
        type_name = str(event.data.get("type", ""))
        try:
            return value_view(type_name, reader.value(event))
        except GripError as error:  # too big, of a class that can't be restored, or written by an earlier version
            return unkept_view(type_name, str(event.data.get("preview", "")), error)

    def raw(self, run: str, seq: int) -> Any:
        """Return what the write with this number wrote, as it was."""
        reader, event = self._write_of(run, seq)
        return reader.value(event)

    def _write_of(self, run: str, seq: int) -> tuple[JournalReader, Event]:
        reader = self._reader()
        found = [] if reader is None else reader.events(run, seq - 1, 1)
        if reader is None or not found or found[0].seq != seq or found[0].event != "write":
            raise UnknownNameError("write of a variable", str(seq), (), f"the run {run}")
        return reader, found[0]

    def end_run(self, run: str) -> None:
        """Enter that a run was stopped whose process could not do so itself."""
        if self._find(run).status in ("running", "died"):
            with Journal(self.file) as journal:
                RunLog(journal, run).end("stopped", None)

    def _find(self, run: str) -> JournalRecord:
        reader = self._reader()
        if reader is None:
            raise UnknownNameError("run", run, ())
        return reader.run(run)

    def _reader(self) -> JournalReader | None:
        with self._lock:
            if self._opened is None and self.file.is_file():
                try:
                    self._opened = JournalReader(self.file)
                except JournalError as error:
                    if "no such table" not in str(error):
                        raise
                    # A run has just made the file and is about to make its tables.
            return self._opened

    def _wire(self, record: JournalRecord) -> RunRecord:
        path = Path(record.task_path)
        if path.is_relative_to(self._folder):
            record = replace(record, task_path=path.relative_to(self._folder).as_posix())
        return RunRecord.model_validate(record)
