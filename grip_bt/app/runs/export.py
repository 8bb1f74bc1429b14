"""A run of the journal as a file for other tools: lines of JSON, a table, or a recording for Foxglove or Rerun."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import asdict
from pathlib import Path

from grip_bt.base.errors import DocumentError, UnknownNameError
from grip_bt.runtime import Event, JournalReader, RunRecord

from .export_mcap import write_mcap
from .export_rerun import write_rerun
from .foxglove import COLUMNS


def export_run(reader: JournalReader, run: str, file: Path, to: str) -> int:
    """Write the events of a run to a file as `jsonl`, `csv`, `mcap` or `rerun`; return how many there were.

    Raises:
        UnknownNameError: there is no such run or format.
        MissingPartError: the library for the format isn't installed.
        DocumentError: the file can't be written.
    """
    if to not in FORMATS:
        raise UnknownNameError("format", to, FORMATS)
    record, count = reader.run(run), 0
    try:
        with FORMATS[to](reader, record, file) as write:
            for event in reader.iterate(run):
                write(event)
                count += 1
    except OSError as error:
        raise DocumentError(f"can't be written: {error.strerror}", str(file)) from None
    return count


_Write = Callable[[Event], object]


@contextmanager
def _jsonl(reader: JournalReader, record: RunRecord, file: Path) -> Iterator[_Write]:
    with file.open("w", encoding="utf-8", errors="backslashreplace") as lines:
        yield lambda event: lines.write(json.dumps(asdict(event), ensure_ascii=False) + "\n")


@contextmanager
def _csv(reader: JournalReader, record: RunRecord, file: Path) -> Iterator[_Write]:
    with file.open("w", encoding="utf-8", newline="", errors="backslashreplace") as table:
        writer = csv.DictWriter(table, COLUMNS, extrasaction="ignore")
        writer.writeheader()
        yield lambda event: writer.writerow(
            {**asdict(event), "data": json.dumps(event.data, ensure_ascii=False) if event.data else ""}
        )


FORMATS: dict[str, Callable[[JournalReader, RunRecord, Path], AbstractContextManager[_Write]]] = {
    "jsonl": _jsonl,
    "csv": _csv,
    "mcap": write_mcap,
    "rerun": write_rerun,
}
