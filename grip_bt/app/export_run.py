"""A run of the journal as a file for other tools: lines of JSON, a table, or a recording that Foxglove opens."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from grip_bt.base.errors import DocumentError, UnknownNameError
from grip_bt.runtime import JournalReader

COLUMNS = ("seq", "t", "wall", "path", "event", "outcome", "code", "data", "meaning")


def export_run(reader: JournalReader, run: str, file: Path, to: str) -> int:
    """Write the events of a run to a file; return how many there were.

    Args:
        reader: of the journal.
        run: its id.
        file: written anew.
        to: `jsonl`, `csv` or `mcap`.

    Raises:
        UnknownNameError: there is no such run or format.
        MissingPartError: `mcap` isn't installed.
        DocumentError: the file can't be written.
    """
    if to not in FORMATS:
        raise UnknownNameError("format", to, FORMATS)
    reader.run(run)
    try:
        return FORMATS[to](reader, run, file)
    except OSError as error:
        raise DocumentError(f"can't be written: {error.strerror}", str(file)) from None


def _jsonl(reader: JournalReader, run: str, file: Path) -> int:
    count = 0
    with file.open("w", encoding="utf-8", errors="backslashreplace") as lines:
        for event in reader.iterate(run):
            lines.write(json.dumps(asdict(event), ensure_ascii=False) + "\n")
            count += 1
    return count


def _csv(reader: JournalReader, run: str, file: Path) -> int:
    count = 0
    with file.open("w", encoding="utf-8", newline="", errors="backslashreplace") as table:
        writer = csv.writer(table)
        writer.writerow(COLUMNS)
        for event in reader.iterate(run):
            row = asdict(event)
            row["data"] = json.dumps(event.data, ensure_ascii=False) if event.data else ""
            writer.writerow([row[column] for column in COLUMNS])
            count += 1
    return count


def _mcap(reader: JournalReader, run: str, file: Path) -> int:
    from .export_mcap import write_mcap

    return write_mcap(reader, run, file)


FORMATS: dict[str, Callable[[JournalReader, str, Path], int]] = {"jsonl": _jsonl, "csv": _csv, "mcap": _mcap}
