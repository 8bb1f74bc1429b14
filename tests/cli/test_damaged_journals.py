"""Journals that something has damaged: what is before is shown, what is bad is named, and nothing raises."""

from __future__ import annotations

import json
import os
import random
import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path

import pytest

from grip_bt.cli.__main__ import main
from grip_bt.runtime import Journal, JournalError, JournalReader

TRIALS = int(os.environ.get("GRIP_FUZZ_DAMAGE", "4"))
"""Damaged files of each kind."""
TASK = """\
grip: 1
name: mended
data: {reached: {type: int, value: 0}, much: str}
root:
  kind: fallback
  children:
    broken: {node: flow/fail, with: {code: no_plan, message: the way is blocked}}
    second:
      kind: sequence
      children:
        big: {node: flow/set, with: {value: '%s'}, out: {value: much}}
        small: {node: flow/set, with: {value: 7}, out: {value: reached}}
        rest: {node: flow/wait, with: {seconds: 0.001}}
"""
COLUMNS = {
    "runs": ("id", "task_name", "task_path", "task_text", "target", "seed", "started", "ended", "status", "outcome"),
    "processes": ("run", "pid", "since", "host"),
    "names": ("id", "path", "event", "outcome", "code"),
    "blocks": ("run", "first", "last", "content", "data", "sum"),
    "big_values": ("hash", "type", "size", "content"),
}
WRONG = (
    *(
        None,
        "",
        "abc",
        0,
        -1,
        10**18,
        1.5,
        float("inf"),
        -1e300,
        b"",
        b"\x00\xff\xfe",
        b"z" + b"\x00" * 50,
        "\x00",
        "[]",
    ),
    *('{"0": []}', '{"0": {"message": {}}}', '{"x": 1}', "{" * 5000, "[" * 200_000, '{"0": {"value": {"$array": 1}}}'),
    *('{"1": {"variable": 3, "value": {"$value": ["Pose", {}]}}}', "\U0010ffff", b"z" + b"x\x9c" + os.urandom(4000)),
    *('{"0": {"outcomes": {"/": 3}, "options": {"robot": 7, "seed": "x", "data": []}}}', '{"0": {"text": "\\ud800"}}'),
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project whose journal has a run that has ended, one of many blocks, and one that died."""
    folder = tmp_path_factory.mktemp("damaged")
    (folder / "grip.yaml").write_text("grip: 1\n")
    task = folder / "mended.yaml"
    task.write_text(TASK % ("much " * 300))
    here = Path.cwd()
    os.chdir(folder)
    try:
        assert main(["run", "mended.yaml", "--in-process", "--robot", "fake"]) == 0
        file = folder / ".grip" / "runs.sqlite"
        with JournalReader(file) as reader:
            events = reader.events(reader.runs()[0].id)
        with Journal(file) as journal:
            died = journal.begin("mended", "mended.yaml", task.read_text())
            for event in events[:-4]:
                died.append(event.t, event.path, event.event, event.outcome, event.code, event.data)
            died.cut(1.0, "killed")
            long = journal.begin("mended", "mended.yaml", task.read_text())
            for number in range(40):
                long.append(number, "/" if number % 2 else "broken", "message", data={"text": f"word {number}"})
                journal.flush()
            long.end("success", "success")
        with closing(sqlite3.connect(file)) as database:
            database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    finally:
        os.chdir(here)
    return folder


@pytest.fixture
def copy(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The project, to be damaged."""
    made = shutil.copytree(folder, tmp_path / "p")
    monkeypatch.chdir(made)
    return made / ".grip" / "runs.sqlite"


def verbs(run: str) -> Iterator[list[str]]:
    """Yield every way to read a run."""
    yield ["runs"]
    yield ["runs", "--json"]
    yield ["runs", run, "--data"]
    for to in ("jsonl", "csv", "mcap"):
        yield ["runs", run, "--to", to, "-o", f"out.{to}"]
    yield ["replay", run, "--speed", "0"]
    yield ["replay", run, "--json", "--speed", "0", "--until", "5"]
    yield ["run", "--resume", run, "--in-process", "--yes"]
    yield ["run", "--fork", run, "--at", "2", "--in-process", "--robot", "fake"]
    yield ["runs", ".", "--prune", "1kB"]


def said(words: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    """Run a verb; return its status and what it said. Whatever it raises fails the test."""
    capsys.readouterr()
    status = main(words)
    out, err = capsys.readouterr()
    assert "Traceback" not in err, (words, err)
    assert status in (0, 1, 3, 4), (words, err)
    if status == 1:
        assert err.strip(), (words, "nothing is said")
    return status, out, err


def look(file: Path, run: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Read a damaged journal in every way, and as the page does."""
    for words in verbs(run):
        said(words, capsys)
    page(file)


def page(file: Path) -> None:
    from grip_bt.base.errors import GripError

    pytest.importorskip("fastapi")
    from grip_gui.runs.journal import JournalRuns

    source = JournalRuns(file, file.parent.parent)
    with suppress(GripError):  # it says what is wrong; anything else is ours
        for record in source.runs():
            record.model_dump_json()
            assert source.run(record.id) is not None
            for event in source.events(record.id, 1, 500):
                event.model_dump_json()
                if event.event == "write":
                    source.value(record.id, event.seq).model_dump_json()


@pytest.mark.parametrize("seed", range(TRIALS))
def test_bytes_that_are_others(copy: Path, seed: int, capsys: pytest.CaptureFixture[str]) -> None:
    choice = random.Random(seed)
    content = bytearray(copy.read_bytes())
    for _ in range(choice.choice((1, 3, 20, 200))):
        content[choice.randrange(100 if choice.random() < 0.05 else 1024, len(content))] = choice.randrange(256)
    copy.write_bytes(content)
    look(copy, "last", capsys)


@pytest.mark.parametrize("seed", range(TRIALS // 2))
def test_files_that_end_too_early_or_have_holes(copy: Path, seed: int, capsys: pytest.CaptureFixture[str]) -> None:
    choice = random.Random(seed)
    content = copy.read_bytes()
    at = choice.randrange(len(content) // 8, len(content))
    rest = b"\0" * min(4096 * choice.randrange(1, 4), len(content) - at) if seed % 2 else b""
    copy.write_bytes(content[:at] + rest + (content[at + len(rest) :] if seed % 2 else b""))
    look(copy, "last", capsys)


@pytest.mark.parametrize("seed", range(TRIALS))
def test_fields_that_are_something_else(copy: Path, seed: int, capsys: pytest.CaptureFixture[str]) -> None:
    choice = random.Random(seed)
    with closing(sqlite3.connect(copy)) as database, database:
        runs = [row[0] for row in database.execute("SELECT id FROM runs ORDER BY rowid")]
        for _ in range(choice.randrange(1, 4)):
            table = choice.choice(list(COLUMNS))
            column, value = choice.choice(COLUMNS[table]), choice.choice(WRONG)
            count = database.execute(f"SELECT count(*) FROM {table}").fetchone()[0]
            key = {"names": "id", "big_values": "hash"}.get(table, "rowid")
            sql = f"UPDATE OR IGNORE {table} SET {column}=? WHERE {key} IN (SELECT {key} FROM {table} LIMIT 1 OFFSET ?)"
            database.execute(sql, (value, choice.randrange(max(count, 1))))
    look(copy, choice.choice(runs), capsys)


def test_the_bad_block_is_named_and_what_is_before_it_is_shown(copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with closing(sqlite3.connect(copy)) as database, database:
        (run,) = database.execute("SELECT run FROM blocks GROUP BY run ORDER BY count(*) DESC LIMIT 1").fetchone()
        (first, last) = database.execute("SELECT first, last FROM blocks WHERE run=? AND first=11", (run,)).fetchone()
        database.execute(
            "UPDATE blocks SET content=substr(content, 1, 3) || x'55' || substr(content, 5) WHERE run=? AND first=11",
            (run,),
        )
    status, out, err = said(["replay", run, "--speed", "0", "--json"], capsys)
    assert status == 1
    assert f"events {first} to {last} of run {run} can't be read: its bytes aren't those that were written" in err
    assert (first, last) == (11, 11)
    assert [json.loads(line)["seq"] for line in out.splitlines()] == list(range(1, 11))
    status, out, err = said(["run", "--resume", run, "--in-process"], capsys)
    assert status == 1
    assert f"grip run --fork {run} --at 10" in err
    status, out, _ = said(["runs"], capsys)
    assert (status, len(out.splitlines())) == (0, 3), "the list needs no events"


def test_a_journal_without_its_first_page_says_that_it_is_none(copy: Path) -> None:
    content = copy.read_bytes()
    for start, end in ((0, 16), (16, 100), (100, 4096), (0, 4096)):
        copy.write_bytes(content[:start] + bytes(end - start) + content[end:])
        with pytest.raises(JournalError, match="isn't a journal"):
            JournalReader(copy)


def test_a_value_whose_bytes_are_others_is_named_and_its_preview_shown(
    copy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with closing(sqlite3.connect(copy)) as database, database:
        database.execute("UPDATE big_values SET content=x'789c0300000000'")
        (run,) = database.execute("SELECT id FROM runs WHERE rowid=1").fetchone()
    status, out, _ = said(["runs", run, "--data"], capsys)
    assert "much much" in out
    status, _, err = said(["run", "--fork", run, "--at", "second/rest", "--in-process"], capsys)
    assert (status, "is damaged" in err) == (1, True)
