"""Whatever of a journal is damaged: all else is shown as it was written, and what isn't shown is said."""

from __future__ import annotations

import re
import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from grip_bt.runtime import Event, Journal, JournalError, JournalReader, ManualClock
from grip_bt.runtime.journal_events import DAMAGED
from grip_bt.runtime.observers import Recorder

BLOCKS, PAGE = 18, 4096
WRONG = (
    None,
    "",
    "abc",
    0,
    1,
    -1,
    1.5,
    10**18,
    float("inf"),
    -1e300,
    b"",
    b"\x00\xff",
    b"z\x00",
    "\x00",
    "[]",
    '{"0": 1}',
)
COLUMNS = ("first", "last", "content", "data", "sum")
HOLE = re.compile(r"events? (\d+)(?: to (\d+))? of run")


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A journal of three runs; the one in the middle has many blocks, in each of which something is written."""
    file = tmp_path_factory.mktemp("whole") / "runs.sqlite"
    with Journal(file) as journal:
        logs, clock = [journal.begin("pick", "pick.yaml", "grip: 1", "sm", 7) for _ in range(3)], ManualClock()
        recorders = [Recorder(log, clock) for log in logs]
        for number in range(BLOCKS + 2):  # the first block and the last one are of the run in the middle
            recorder = recorders[{1: 0, 2: 2}.get(number, 1)]
            recorder.entered("a")
            recorder.wrote("a", f"v{number % 5}", "str", f"word {number}." + 440 * "x")
            recorder.ended("a", "success", None)
            clock.advance(0.1)
            journal.flush()
        for log in logs:
            log.end("success", "success")
    with closing(sqlite3.connect(file)) as database:
        database.execute("VACUUM")  # nothing is left in it of what was elsewhere before
    return file


@pytest.fixture
def file(whole: Path, tmp_path: Path) -> Path:
    """A copy of it, to be damaged."""
    return Path(shutil.copy(whole, tmp_path / "runs.sqlite"))


def long_run(file: Path) -> str:
    with JournalReader(file) as reader:
        return max((record.id for record in reader.runs()), key=reader.count)


def change(file: Path, statement: str, *values: Any) -> None:
    with closing(sqlite3.connect(file)) as database, database:
        database.execute(statement, values)


def missing_of(reader: JournalReader, run: str, written: dict[int, Event], lost: set[int]) -> set[int]:
    """Return which events aren't shown, of which at most those `lost` may be; each has to be named."""
    found = reader.events(run)
    assert [event.seq for event in found] == sorted({event.seq for event in found})
    shown = {event.seq: event for event in found if event.event != DAMAGED}
    outside = written.keys() - lost
    assert {seq: shown.get(seq) for seq in outside} == {seq: written[seq] for seq in outside}
    named: set[int] = set()
    for hole in (event for event in found if event.event == DAMAGED):
        first, last = HOLE.match(hole.data["message"]).groups()  # type: ignore[union-attr]
        named |= set(range(int(first), int(last or first) + 1))
        assert max(named) == hole.seq
    assert not named & shown.keys()
    missing = written.keys() - shown.keys()
    assert not missing or reader.damage
    assert missing - named in (set(), set(range(max({0, *shown.keys(), *named}) + 1, len(written) + 1))), "but an end"
    pages, after = [], 0
    while page := reader.events(run, after, 5):
        pages += page
        after = page[-1].seq
    assert [(event.seq, event.event) for event in pages] == [(event.seq, event.event) for event in found]
    writes = [event for event in shown.values() if event.event == "write"]
    assert reader.variables(run) == {event.data["variable"]: event for event in writes}
    assert reader.history(run, "v0", 99) == [event for event in writes if event.data["variable"] == "v0"]
    return missing


def damages(file: Path, run: str) -> Iterator[tuple[str, Any, tuple[int, int]]]:
    """Yield a column, what it becomes, and the first and last event of the block whose column that is."""
    with closing(sqlite3.connect(file)) as database:
        stored = database.execute("SELECT first, last FROM blocks WHERE run=? ORDER BY first", (run,)).fetchall()
    assert len(stored) >= BLOCKS
    yield from ((column, 1, stored[0]) for column in ("content", "data"))
    for first, last in (stored[7], stored[-1]):
        near = {"first": (first - 1, first + 1, first - 5), "last": (last - 1, last + 1, last + 5, first + 60_000)}
        for column in COLUMNS:
            wrong = WRONG if (column in near) is (first == stored[-1][0]) else WRONG[::3]
            yield from ((column, value, (first, last)) for value in (*wrong, *near.get(column, ())))


def test_a_block_with_another_field_takes_nothing_else_along(file: Path) -> None:
    run = long_run(file)
    content = file.read_bytes()
    with JournalReader(file) as reader:
        written = {event.seq: event for event in reader.events(run)}
        assert not reader.damage
        assert reader.count(run) == len(written)
    assert {event.meaning for event in written.values() if event.event == "exit"} == {"success"}
    for column, value, (first, last) in damages(file, run):
        change(file, f"UPDATE OR IGNORE blocks SET {column}=? WHERE run=? AND first=?", value, run, first)
        with JournalReader(file) as reader:
            missing_of(reader, run, written, set(range(first, last + 1)))
            if last < len(written):
                assert reader.count(run) == len(written), (column, value)
        file.write_bytes(content)


def test_events_without_a_name_are_named_by_their_numbers(file: Path) -> None:
    run = long_run(file)
    content = file.read_bytes()
    with JournalReader(file) as reader:
        written = {event.seq: event for event in reader.events(run)}
        others = [reader.events(record.id) for record in reader.runs() if record.id != run]
    for column in ("id", "path", "event", "outcome", "code"):
        for value in WRONG:
            change(file, f"UPDATE OR IGNORE names SET {column}=? WHERE run=? AND id=1", value, run)
            with JournalReader(file) as reader:
                found = reader.events(run)
                assert {event.seq for event in found if event.event != DAMAGED} in (set(), set(written))
                assert found[-1].seq == len(written)
                assert all(isinstance(text, str) and text for event in found for text in (event.path, event.event))
                assert bool(reader.damage) == any(event.event == DAMAGED for event in found)
                assert [reader.events(record.id) for record in reader.runs() if record.id != run] == others
            file.write_bytes(content)


@pytest.mark.parametrize("byte", [0, 255])
def test_a_page_of_the_file_changes_nothing_that_is_shown(file: Path, byte: int) -> None:
    run = long_run(file)
    content = file.read_bytes()
    with JournalReader(file) as reader:
        written = {event.seq: event for event in reader.events(run)}
        records = {record.id: record for record in reader.runs()}
    shown, refused = 0, []
    for start in range(PAGE, len(content), PAGE):
        file.write_bytes(content[:start] + bytes([byte]) * PAGE + content[start + PAGE :])
        try:
            with JournalReader(file) as reader:
                missing_of(reader, run, written, set(written))
                assert all(records[record.id] == record for record in reader.runs())
                shown += 1
        except JournalError as error:
            refused.append(str(error))
    assert shown >= 3
    assert all(".recover" in said or "isn't a journal" in said for said in refused)


@pytest.mark.parametrize("row", [1, 2, 3])
def test_a_field_of_a_run_that_is_no_such_thing_is_named_and_the_others_are_shown(file: Path, row: int) -> None:
    content = file.read_bytes()
    with JournalReader(file) as reader:
        records = reader.runs()[::-1]
        assert not reader.damage
    for record in records:
        assert (record.task_name, record.task_path, record.task_text) == ("pick", "pick.yaml", "grip: 1")
        assert (record.target, record.seed, record.status, record.outcome) == ("sm", 7, "success", "success")
    fields = ("id", "task_name", "task_path", "task_text", "target", "seed", "started", "ended", "status", "outcome")
    for field in fields:
        for value in WRONG:
            change(file, f"UPDATE runs SET {field}=? WHERE rowid=?", value, row)
            with closing(sqlite3.connect(file)) as database:
                (kept,) = database.execute(f"SELECT {field} FROM runs WHERE rowid=?", (row,)).fetchone()
            with JournalReader(file) as reader:
                found = {record.id: record for record in reader.runs()}
                said = "; ".join(reader.damage)
            others = [record for number, record in enumerate(records, 1) if number != row]
            assert [found.pop(record.id) for record in others] == others
            if found:
                (record,) = found.values()
                for name in fields:
                    shown = getattr(record, name)
                    assert shown == (kept if name == field else getattr(records[row - 1], name)) or (
                        name == field and f"{field} of run {record.id} is no such thing" in said
                    ), (field, value, record, said)
                    assert not isinstance(shown, float) or 0 <= shown < 1e11
                assert "\0" not in record.task_path
                assert record.target in ("bt", "sm")
            else:
                assert field == "id"
                assert "has no id" in said
            file.write_bytes(content)


def test_a_journal_without_its_first_page_says_that_it_is_none(file: Path) -> None:
    content = file.read_bytes()
    for start, end in ((0, 16), (16, 100), (100, PAGE), (0, PAGE)):
        file.write_bytes(content[:start] + bytes(end - start) + content[end:])
        with pytest.raises(JournalError, match="isn't a journal"):
            JournalReader(file)
