"""Blocks of events: pages of any size show the same log, old journals are read, and crashes lose nothing shown."""

from __future__ import annotations

import os
import random
import signal
import sqlite3
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from timed import ManualClock

from grip_bt.runtime import Journal, JournalError, JournalReader, WallClock
from grip_bt.runtime import journal as journals
from grip_bt.runtime.journal_events import checksum, packed, unpacked
from grip_bt.runtime.observers import Recorder


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "runs.sqlite"


@pytest.mark.parametrize("largest", [0, 300, 2**31])
@pytest.mark.parametrize("count", [1, 3, 5000])
@pytest.mark.parametrize("together", [True, False])
def test_columns_come_back(largest: int, count: int, together: bool) -> None:
    rng = np.random.default_rng(count)
    ids = rng.integers(0, largest, count, endpoint=True)
    times = np.cumsum(rng.exponential(1e-5, count)) + 1.7e3
    walls = times + 1.7e9 + (0.0 if together else rng.exponential(1.0, count))
    row = (1, count, packed(ids, times, walls), None)
    found = unpacked((*row, checksum(*row)), {int(n): ("a", "b", None, str(n)) for n in ids}, slice(None))
    said = zip(range(count), times, map(str, ids), strict=True)
    assert [(i, at, name[3]) for i, at, _, name, _ in found] == list(said)
    assert np.allclose([on for _, _, on, _, _ in found], walls, rtol=0, atol=1e-3 if together else 1e-6)


def test_pages_of_any_size_show_the_whole_log_once(file: Path) -> None:
    rng, said = random.Random(5), []
    with Journal(file) as journal:
        recorder = Recorder(log := journal.begin("pages"), clock := ManualClock())
        for n in range(2000):
            path = f"n{rng.randrange(300)}"
            said.append((clock.now(), path, kind := rng.choice(["enter", "exit", "interrupted", "message"])))
            {
                "enter": lambda p: recorder.entered(p),
                "exit": lambda p: recorder.ended(p, "success", None),
                "interrupted": lambda p: recorder.interrupted(p),
                "message": lambda p: recorder.message(p, "x"),
            }[kind](path)
            clock.advance(0.1)
            if n % 170 == 0:
                journal.flush()
    with JournalReader(file) as reader:
        assert reader.count(log.id) == 2000
        whole = reader.events(log.id)
        assert [(e.t, e.path, e.event) for e in whole] == said
        assert list(reader.iterate(log.id)) == whole
        for limit in (1, 7, 333, 5000):
            after, found = 0, []
            while page := reader.events(log.id, after, limit):
                assert len(page) <= limit
                found += page
                after = page[-1].seq
                if limit == 1 and after > 50:
                    break
            assert found == whole[: len(found)]
            assert limit == 1 or len(found) == 2000


def test_the_walls_clock_is_told_with_its_pauses(file: Path) -> None:
    clock, told = WallClock(), []
    with Journal(file) as journal:
        recorder = Recorder(log := journal.begin("pauses"), clock)
        for n in range(30):
            before = clock.now()
            recorder.entered("a")
            told.append((before, clock.now()))
            (clock.pause, clock.resume)[n % 2]()
    with JournalReader(file) as reader:
        events = reader.events(log.id)
    assert all(low - 1e-9 <= event.t <= high + 1e-9 for event, (low, high) in zip(events, told, strict=True))
    assert all(abs(event.wall - time.time()) < 60 for event in events)
    assert [event.wall for event in events] == sorted(event.wall for event in events)


def test_threads_that_append_at_once_lose_nothing_and_keep_their_own_order(file: Path) -> None:
    with Journal(file) as journal:
        recorder = Recorder(log := journal.begin("threads"), WallClock())

        def work(name: str) -> None:
            for n in range(3000):
                recorder.ended(name, str(n), None)

        threads = [threading.Thread(target=work, args=(f"t{i}",)) for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    with JournalReader(file) as reader:
        events = reader.events(log.id)
    for i in range(4):
        assert [event.outcome for event in events if event.path == f"t{i}"] == [str(n) for n in range(3000)]


def test_who_appends_faster_than_is_written_waits(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("grip_bt.runtime.observers.LIMIT", 1000)
    monkeypatch.setattr(journals, "LIMIT", 1000)
    longest = 0
    with Journal(file) as journal:
        recorder = Recorder(log := journal.begin("fast"), WallClock())
        for n in range(20_000):
            recorder.ended("a", str(n % 10), None)
            longest = max(longest, len(log.buffer) // 4)
    assert longest <= 1001
    with JournalReader(file) as reader:
        assert reader.count(log.id) == 20_000


def test_a_run_goes_on_where_another_process_stopped_writing_it(file: Path) -> None:
    with Journal(file) as journal:
        log = journal.begin("resumed")
        log.append(0, "a", "enter")
        log.append(1, "b", "enter")
    with Journal(file) as journal:
        again = journals.RunLog(journal, log.id)
        again.append(2, "b", "enter")
        again.append(3, "c", "enter")
    with JournalReader(file) as reader:
        assert [(e.seq, e.path) for e in reader.events(log.id)] == [(1, "a"), (2, "b"), (3, "b"), (4, "c")]


@pytest.mark.parametrize("version", [2, 99])
def test_a_journal_of_another_version_is_refused(file: Path, version: int) -> None:
    Journal(file).close()
    with sqlite3.connect(file) as database:
        database.execute(f"PRAGMA user_version={version}")
    database.close()
    for opened in (JournalReader, Journal):
        with pytest.raises(JournalError, match=f"of version {version}, this GRIP reads version 3"):
            opened(file)


WRITER = """
import sys
from grip_bt.runtime import Journal, WallClock
from grip_bt.runtime.observers import Recorder
journal = Journal(sys.argv[1])
recorder = Recorder(journal.begin("doomed"), WallClock())
journal.on_commit(lambda run, seq: print(run, seq, flush=True))
n = 0
while True:
    n += 1
    recorder.entered(f"node_{n % 50}")
    recorder.wrote("node", "n", "int", n)
    recorder.ended(f"node_{n % 50}", "success", None)
"""


def killed_after(file: Path, seconds: float) -> tuple[str, int]:
    """Have a process write until it is killed; return its run and what it announced last."""
    command = [sys.executable, "-c", WRITER, str(file)]
    writer = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert writer.stdout is not None
    told = [writer.stdout.readline()]
    time.sleep(seconds)
    os.kill(writer.pid, signal.SIGKILL)
    told += writer.stdout.read().splitlines(keepends=True)
    writer.stdout.close()
    assert writer.wait() == -signal.SIGKILL
    run, seq = [line for line in told if line.endswith("\n")][-1].split()
    return run, int(seq)


@pytest.mark.timeout(1800)
def test_nothing_that_was_shown_is_lost_whenever_the_process_is_killed(file: Path) -> None:
    rng = random.Random(int(os.environ.get("GRIP_FUZZ_SEED", "0")))
    for _ in range(int(os.environ.get("GRIP_FUZZ_KILLS", "4"))):
        run, announced = killed_after(file, rng.uniform(0, 0.3))
        with JournalReader(file) as reader:
            assert reader.run(run).status == "died"
            count, after = reader.count(run), max(0, announced - 500)
            assert count >= announced
            tail = reader.events(run, after)
            assert [event.seq for event in tail] == list(range(after + 1, count + 1))
            for event in tail:
                n = (event.seq - 1) // 3 + 1
                assert event.event == ("enter", "write", "exit")[(event.seq - 1) % 3]
                assert event.event != "write" or reader.value(event) == n
