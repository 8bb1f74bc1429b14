"""A stranger's folder, looked at in every way: nothing of it is imported, executed or started."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from hostile_project import make, marks

from grip_bt.cli.shell import VERBS

RUN = {
    "run",
    "demo",
    "bench",
    "serve",
    "launch",
    "component",
    "import",
    "sim",
    "messages",
    "edit",
    "teach",
    "robot",
    "world",
    "object",
}
"""Verbs that run something, at least with one of their words; docs/trust.md says what."""
LOOK = {
    "check",
    "fmt",
    "convert",
    "runs",
    "replay",
    "new",
    "apply",
    "interfaces",
    "docs",
    "doctor",
    "completion",
    "help",
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    made = tmp_path / "stranger"
    make(made)
    (tmp_path / "out").mkdir()
    (tmp_path / "cache").mkdir()
    return made


def walked(folder: Path, what: str) -> tuple[list[str], dict[str, str]]:
    """Return what was done that isn't ours, and what came of each way of looking."""
    script = Path(__file__).with_name("hostile_walk.py")
    cache = str(folder.parent / "cache")
    tools = folder.parent / "bin" / "ros2"  # what would run launch files
    tools.parent.mkdir()
    tools.write_text("#!/bin/sh\n")
    tools.chmod(0o755)
    path = f"{tools.parent}:{os.environ['PATH']}"
    env = {**os.environ, "XDG_CACHE_HOME": cache, "TMPDIR": cache, "PATH": path}
    done = subprocess.run(
        [sys.executable, str(script), str(folder), what],
        capture_output=True,
        text=True,
        cwd=folder.parent / "out",
        env=env,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    told: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return told["acts"], told["done"]


def test_every_verb_is_known_to_run_something_or_not() -> None:
    assert set(VERBS) == RUN | LOOK


def test_no_verb_that_looks_runs_anything(folder: Path) -> None:
    before = {file: file.read_bytes() for file in folder.rglob("*") if file.is_file()}
    acts, done = walked(folder, "verbs")
    assert (acts, marks(folder)) == ([], [])
    assert [way for way, said in done.items() if "Traceback" in said] == []
    assert {file: file.read_bytes() for file in before} == before
    checked = done[next(way for way in done if way.startswith("check "))]
    assert checked.startswith("1:"), checked
    made = {way: said for way, said in done.items() if "tasks/listed" in way and "--to bt " in way}
    assert made
    assert all(said.startswith("0:") for said in made.values()), made


def test_no_route_of_the_page_that_looks_runs_anything(folder: Path) -> None:
    acts, done = walked(folder, "routes")
    assert (acts, marks(folder)) == ([], [])
    assert [way for way, said in done.items() if said.startswith("5")] == []
    assert any(said.startswith("200") and "conversion" in way for way, said in done.items()), done


def test_no_code_refuses_to_run_strangers_code_and_says_what_there_is(folder: Path) -> None:
    acts, done = walked(folder, "refused")
    assert (acts, marks(folder)) == ([], [])
    assert [way for way, said in done.items() if "Traceback" in said or "third-party code" not in said] == []
