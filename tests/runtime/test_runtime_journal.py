"""The journal: what is written, in which order, and that nothing acknowledged is lost."""

from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sys
import threading
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from runtime_world import TARGETS, Started, leaf

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.value_codec import preview
from grip_bt.runtime import Journal, JournalError, JournalReader


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "deep" / "runs.sqlite"


def test_events_are_read_in_the_order_in_which_they_were_appended(file: Path) -> None:
    with Journal(file) as journal:
        log = journal.begin("pick", "tasks/pick.yaml", "grip: 1", "sm", 7)
        for n in range(1000):
            log.append(n / 10, f"a/{n}", "enter", data={"n": n})
        log.end("success", "placed")
    with JournalReader(file) as reader:
        events = reader.events(log.id)
        assert [event.seq for event in events] == list(range(1, 1001))
        assert [event.data["n"] for event in events] == list(range(1000))
        assert reader.events(log.id, after_seq=998) == events[-2:]
        run = reader.run(log.id)
    assert (run.task_name, run.task_path, run.task_text, run.target, run.seed) == (
        "pick",
        "tasks/pick.yaml",
        "grip: 1",
        "sm",
        7,
    )
    assert (run.status, run.outcome) == ("success", "placed")
    assert run.ended is not None
    assert run.ended >= run.started


def test_what_was_announced_can_be_read_at_that_moment(file: Path) -> None:
    seen: list[tuple[int, int]] = []
    with Journal(file) as journal:
        log = journal.begin("pick")

        def check(run: str, seq: int) -> None:
            with JournalReader(file) as reader:
                seen.append((seq, len(reader.events(run))))

        journal.on_commit(check)
        for n in range(200):
            log.append(n, "/", "enter")
        journal.flush()
    assert seen[-1] == (200, 200)
    assert all(announced <= readable for announced, readable in seen)


def test_two_runs_are_numbered_each_by_itself_and_the_newest_is_first(file: Path) -> None:
    with Journal(file) as journal:
        logs = [journal.begin(name) for name in ("one", "two")]
        for _ in range(3):
            for log in logs:
                log.append(0, "/", "enter")
    with JournalReader(file) as reader:
        assert [run.task_name for run in reader.runs()] == ["two", "one"]
        assert [[event.seq for event in reader.events(log.id)] for log in logs] == [[1, 2, 3]] * 2
        assert reader.run(logs[0].id).status == "running"


WRITER = """
import sys
from grip_bt.runtime import Journal
journal = Journal(sys.argv[1])
log = journal.begin("doomed")
journal.on_commit(lambda run, seq: print(run, seq, flush=True))
n = 0
while True:
    for _ in range(20):
        n += 1
        log.append(n, "/", "enter", data={"n": n})
    journal.flush()
"""


def test_who_flushes_waits_for_however_long_another_process_has_the_file(file: Path) -> None:
    with Journal(file) as journal:
        log = journal.begin("patient")
        journal.flush()
        with closing(sqlite3.connect(file, isolation_level=None)) as other:
            other.execute("BEGIN IMMEDIATE")
            log.append(0, "/", "enter")
            returned = threading.Event()
            thread = threading.Thread(target=lambda: (journal.flush(), returned.set()), daemon=True)
            thread.start()
            assert not returned.wait(0.5), "nothing can have been committed"
            other.execute("ROLLBACK")
            thread.join(60)
        assert returned.is_set()
        with JournalReader(file) as reader:
            assert reader.count(log.id) == 1


def test_a_killed_writer_loses_nothing_that_it_announced(file: Path) -> None:
    writer = subprocess.Popen([sys.executable, "-c", WRITER, str(file)], stdout=subprocess.PIPE, text=True)
    assert writer.stdout is not None
    announced = "0"
    while int(announced) < 200:
        run, announced = writer.stdout.readline().split()
    os.kill(writer.pid, signal.SIGKILL)
    for line in writer.stdout.read().splitlines(keepends=True):
        if line.endswith("\n"):
            run, announced = line.split()
    writer.stdout.close()
    assert writer.wait() == -signal.SIGKILL
    with JournalReader(file) as reader:
        events = reader.events(run)
    assert len(events) >= int(announced) >= 200
    assert [event.data["n"] for event in events] == list(range(1, len(events) + 1))


def test_a_file_that_is_no_journal_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "text.sqlite"
    with pytest.raises(JournalError, match="there is no journal"):
        JournalReader(file)
    file.write_text("this is not a database, and long enough to look like none " * 20)
    with pytest.raises(JournalError, match="isn't a journal"):
        JournalReader(file)
    with pytest.raises(JournalError, match="can't be opened"):
        Journal(file)


def test_an_unknown_run_is_named_with_those_that_exist(file: Path) -> None:
    with Journal(file) as journal:
        log = journal.begin("pick")
    with JournalReader(file) as reader, pytest.raises(UnknownNameError, match=log.id):
        reader.run("nope")


def test_a_journal_that_cannot_be_written_says_so(file: Path) -> None:
    journal = Journal(file)
    log = journal.begin("pick")
    journal.flush()
    with sqlite3.connect(file) as database:
        database.execute("DROP TABLE blocks")
    database.close()
    log.append(0, "/", "enter")
    with pytest.raises(JournalError, match="couldn't be written"):
        journal.flush()


@pytest.mark.parametrize("target", TARGETS)
def test_a_run_writes_every_activation_and_every_write(target: Any, file: Path) -> None:
    root = {"kind": "sequence", "children": {"a": leaf("end", out={"x": "list"}), "w": leaf("wait")}}
    with Journal(file) as journal:
        run = Started(target, root, journal=journal, data={"list": "list[int]"}).start()
        run.wait_tick("w")
        run.leaves["w"].told.set()
        run.context.wake()
        run.join()
    with JournalReader(file) as reader:
        events = [(e.path, e.event, e.outcome) for e in reader.events(run.runner.run_id)]
        write = next(e for e in reader.events(run.runner.run_id) if e.event == "write")
    assert events == [
        ("/", "run_started", None),
        ("/", "enter", None),
        ("a", "enter", None),
        ("a", "write", None),
        ("a", "exit", "success"),
        ("w", "enter", None),
        ("w", "message", None),
        ("w", "exit", "success"),
        ("/", "exit", "success"),
        ("/", "run_ended", "success"),
    ]
    assert write.data == {"variable": "list", "type": "list[int]", "preview": "[1, 2, 3]", "value": [1, 2, 3]}


@pytest.mark.parametrize("target", TARGETS)
def test_an_interrupted_run_and_an_error_are_written_with_the_traceback(target: Any, file: Path) -> None:
    children = {"w": leaf("wait"), "b": leaf("break")}
    with Journal(file) as journal:
        run = Started(target, {"kind": "parallel", "children": children}, journal=journal)
        run.start().join()
    with JournalReader(file) as reader:
        events = reader.events(run.runner.run_id)
        assert reader.run(run.runner.run_id).status == "error"
    assert [e.path for e in events if e.event == "interrupted"] == ["b", "w", "/"]
    error = next(e for e in events if e.event == "error")
    assert (error.path, error.data["type"], error.data["message"]) == ("b", "RuntimeError", "the arm fell off")
    assert 'raise RuntimeError("the arm fell off")' in error.data["traceback"]
    assert events[-1].data == {"status": "error"}


def test_previews_of_big_values_are_short() -> None:
    for value in (list(range(10**6)), "x" * 10**6, {n: "y" * 1000 for n in range(1000)}):
        assert len(preview(value)) <= 120


@pytest.mark.parametrize("target", TARGETS)
def test_a_run_that_is_never_begun_is_entered_as_stopped_and_one_that_has_ended_stays(target: Any, file: Path) -> None:
    with Journal(file) as journal:
        idle = Started(target, leaf("end"), journal=journal)
        idle.runner.dismiss()
        done = Started(target, leaf("end"), journal=journal).start()
        done.join()
        done.runner.dismiss()
        runs = [idle.runner.run_id, done.runner.run_id]
    with JournalReader(file) as reader:
        assert [reader.run(run).status for run in runs if run] == ["stopped", "success"]


def test_nobody_who_has_a_run_cut_off_goes_on_before_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with Journal(tmp_path / "runs.sqlite") as journal:
        log = journal.begin("t")
        inside, released, note = threading.Event(), threading.Event(), log.note

        def slow(*event: Any) -> None:
            inside.set()
            assert released.wait(60)
            note(*event)

        def cut_and_interrupt() -> None:
            log.cut(1.0, "whoever controlled it has gone")
            log.append(1.0, "a", "interrupted")

        monkeypatch.setattr(log, "note", slow)
        first = threading.Thread(target=log.cut, args=(1.0, "whoever controlled it has gone"))
        first.start()
        assert inside.wait(60)
        monkeypatch.setattr(log, "note", note)
        second = threading.Thread(target=cut_and_interrupt)
        second.start()
        second.join(0.2)
        released.set()
        for thread in (first, second):
            thread.join(60)
    with JournalReader(tmp_path / "runs.sqlite") as reader:
        assert [event.event for event in reader.events(log.id)] == ["run_ended"]
