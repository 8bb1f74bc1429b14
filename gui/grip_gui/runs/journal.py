"""Runs, their events and values for the page, out of the journal: the live view and the replay read the same."""

from __future__ import annotations

import dataclasses
import threading
from pathlib import Path
from typing import Any

from grip_bt.base.errors import GripError, UnknownNameError
from grip_bt.runtime import Event, JournalError, JournalReader
from grip_bt.runtime import RunRecord as JournalRecord
from grip_gui.runs.values import value_view
from grip_gui.wire.runs import RunEvent, RunRecord, ValueView

LISTED = 100  # most runs that are offered


class JournalRuns:
    """The runs of a journal file; as long as there is no file there are no runs. Safe to use from several threads.

    The paths of their tasks are relative to the project folder.
    """

    def __init__(self, file: Path, folder: Path):
        self.file, self._folder = file, folder
        self._lock = threading.Lock()
        self._opened: JournalReader | None = None

    def runs(self) -> list[RunRecord]:
        """Return the latest runs, newest first."""
        reader = self._reader()
        return [self._wire(record) for record in reader.runs()[:LISTED]] if reader else []

    def run(self, run: str) -> RunRecord:
        """Return one run; UnknownNameError where there is none."""
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
            text = str(event.data.get("preview", ""))
            return ValueView(type=type_name, text=text, rows=[["not kept", str(error)]])

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
            record = dataclasses.replace(record, task_path=path.relative_to(self._folder).as_posix())
        return RunRecord.model_validate(record)
