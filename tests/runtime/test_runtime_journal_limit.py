"""Journals that make room: the oldest runs go, what others need stays, what is under way stays."""

from __future__ import annotations

import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from timed import ManualClock

from grip_bt.runtime import Journal, JournalError, JournalReader
from grip_bt.runtime.journal_room import ROOM, prune, size_of
from grip_bt.runtime.observers import Recorder

KIB = 1024


def noise(seed: int, size: int = 64 * KIB) -> np.ndarray:
    """Something that can't be deflated."""
    return np.random.default_rng(seed).integers(0, 256, size, np.uint8)


def write(journal: Journal, *values: Any, end: bool = True) -> str:
    log = journal.begin("t")
    recorder = Recorder(log, ManualClock())
    recorder.say("run_started")
    for value in values:
        recorder.entered("a")
        recorder.wrote("a", "v", "Any", value)
        recorder.ended("a", "success", None)
    if end:
        recorder.finished("success", "success")
    journal.flush()
    return log.id


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "runs.sqlite"


def test_below_the_limit_nothing_is_removed(file: Path) -> None:
    with Journal(file) as journal:
        runs = [write(journal, noise(i)) for i in range(3)]
    pruned = prune(file, 100 * 1024 * KIB)
    assert (pruned.runs, pruned.before) == ((), pruned.after)
    with JournalReader(file) as reader:
        assert {record.id for record in reader.runs()} == set(runs)


def test_the_oldest_runs_make_room_with_what_only_they_have_written(file: Path) -> None:
    shared = noise(99)
    with Journal(file) as journal:
        runs = [write(journal, noise(i), shared) for i in range(10)]
        pruned = prune(file, 400 * KIB)
        assert pruned.runs == tuple(runs[: len(pruned.runs)]), "the oldest first"
        assert pruned.before > 400 * KIB >= pruned.after
        assert pruned.after > 0.5 * ROOM * 400 * KIB, "no more than need be"
        newest = write(journal, noise(0), shared)
    with JournalReader(file) as reader:
        left = [record.id for record in reader.runs()]
        assert set(left) == {*runs[len(pruned.runs) :], newest}
        for run in left:
            first, second = (reader.value(event) for event in reader.events(run) if event.event == "write")
            assert (second == shared).all(), "what others have written too is still there"
            assert first.shape == shared.shape
    with sqlite3.connect(file) as database:
        (values,) = database.execute("SELECT count(*) FROM big_values").fetchone()
        (rows,) = database.execute("SELECT count(*) FROM blocks WHERE run NOT IN (SELECT id FROM runs)").fetchone()
    assert (values, rows) == (len(left) + 1, 0)


def test_a_run_that_is_under_way_stays_and_goes_on(file: Path) -> None:
    with Journal(file) as journal:
        log = journal.begin("t")
        recorder = Recorder(log, ManualClock())
        recorder.wrote("a", "v", "Any", noise(0))
        journal.flush()
        ended = [write(journal, noise(i)) for i in range(1, 6)]
        pruned = prune(file, 1, keep=lambda run: run == log.id)
        assert pruned.runs == tuple(ended[:-1]), "nor is the newest removed"
        recorder.wrote("a", "v", "Any", noise(1))
        recorder.finished("success", "success")
    with JournalReader(file) as reader:
        assert {record.id for record in reader.runs()} == {log.id, ended[-1]}
        values = [reader.value(event) for event in reader.events(log.id) if event.event == "write"]
        assert (values[1] == noise(1)).all(), "a value that was removed with another run is written again"


def test_what_is_written_while_runs_are_removed_is_kept(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from grip_bt.runtime import journal_room

    shared = noise(7)
    with Journal(file) as journal:
        old = write(journal, shared)
        write(journal, noise(8))
        size, looks, newer = journal_room._in_use, [], []

        def look(*args: Any) -> int:
            looks.append(size(*args))
            if len(looks) == 2:  # between the choice of runs and the removal, another run writes the same value
                newer.append(write(journal, shared))
            return looks[-1]

        monkeypatch.setattr(journal_room, "_in_use", look)
        pruned = prune(file, 130 * KIB)
    assert pruned.runs[0] == old
    assert newer[0] not in pruned.runs
    with JournalReader(file) as reader:
        (event,) = (event for event in reader.events(newer[0]) if event.event == "write")
        assert (reader.value(event) == shared).all()


def test_room_is_given_back_to_the_disk(file: Path) -> None:
    with Journal(file) as journal:
        for i in range(10):
            write(journal, noise(i))
    before = size_of(file)
    prune(file, 200 * KIB, give_back=True)
    assert size_of(file) <= 200 * KIB < before


def test_what_is_no_journal_is_said(tmp_path: Path) -> None:
    (tmp_path / "text.sqlite").write_text("not a database, but long enough to look like a file of one" * 20)
    with pytest.raises(JournalError, match="runs can't be removed: file is not a database"):
        prune(tmp_path / "text.sqlite", 1)
