"""What was shown outlasts a power cut: the order in which the journal writes, waits for the disk, and tells.

What the disk has is asked of the system calls themselves: everything that was written to the write-ahead log has to be
synchronised before somebody is told of it.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from grip_bt.runtime import Journal
from grip_bt.runtime import journal as journals
from grip_bt.runtime.journal_rows import prepare_to_write

WRITER = """
import os, sys
from grip_bt.runtime import Journal
journal = Journal(sys.argv[1])
journal.on_commit(lambda run, seq: os.write(1, b"shown %d\\n" % seq))
log = journal.begin("doomed")
for n in range(10):
    log.append(n, "/", "enter", data={"n": n})
    journal.flush()
os.write(1, b"done\\n")
os._exit(0)
"""
CALL = re.compile(r"(pwrite64|write|fsync|fdatasync)\((\d+)<([^>]*)>(?:, \"([^\"]*)\")?")


def test_the_writer_waits_for_the_disk_at_each_commit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found: list[tuple[int, str]] = []

    def look(database: object) -> None:
        prepare_to_write(database)  # type: ignore[arg-type]
        (level,) = database.execute("PRAGMA synchronous").fetchone()  # type: ignore[attr-defined]
        (mode,) = database.execute("PRAGMA journal_mode").fetchone()  # type: ignore[attr-defined]
        found.append((level, mode))

    monkeypatch.setattr(journals, "prepare_to_write", look)
    with Journal(tmp_path / "runs.sqlite"):
        pass
    assert found == [(2, "wal")], "FULL: the write-ahead log is synchronised before a commit returns"


def test_nothing_is_shown_before_the_disk_has_it(tmp_path: Path) -> None:
    if shutil.which("strace") is None:
        pytest.skip("strace isn't there: system calls can't be watched")
    trace = tmp_path / "trace"
    watch = ["strace", "-f", "-y", "-o", str(trace), "-e", "trace=write,pwrite64,fsync,fdatasync"]
    done = subprocess.run(
        [*watch, sys.executable, "-c", WRITER, str(tmp_path / "runs.sqlite")],
        capture_output=True,
        text=True,
        timeout=900,
    )
    if "ptrace" in done.stderr or "PTRACE" in done.stderr:
        pytest.skip(f"processes can't be traced here: {done.stderr.strip()[:200]}")
    assert done.returncode == 0, done.stderr
    unsynchronised, shown = 0, 0
    for call, file, text in ((m[1], m[3], m[4]) for m in map(CALL.search, trace.read_text().splitlines()) if m):
        if file.endswith("runs.sqlite-wal"):
            unsynchronised = 0 if "sync" in call else unsynchronised + 1
        elif text is not None and text.startswith("shown"):
            shown += 1
            assert unsynchronised == 0, f"{unsynchronised} writes weren't on the disk when {text!r} was said"
    assert shown == 10, trace.read_text()[-2000:]
