"""py_trees' own tests pass when every tick goes through the engine."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tarfile
from pathlib import Path

import py_trees
import pytest

HERE = Path(__file__).parent


@pytest.fixture(scope="module")
def upstream(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The source distribution of the installed py_trees, unpacked."""
    folder = tmp_path_factory.mktemp("upstream")
    version = py_trees.version.__version__
    fetch = ["pip", "download", "-q", "--no-deps", "--no-build-isolation", "--no-binary", ":all:"]
    try:
        done = subprocess.run(
            [sys.executable, "-m", *fetch, f"py_trees=={version}", "-d", str(folder)],
            capture_output=True,
            text=True,
            timeout=900,
        )
    except subprocess.TimeoutExpired:
        pytest.skip("the source distribution of py_trees can't be fetched: no answer within 120 s")
    found = list(folder.glob("*.tar.gz"))
    if not found:
        pytest.skip(f"the source distribution of py_trees can't be fetched: {done.stderr.strip()[-300:]}")
    with tarfile.open(found[0]) as archive:
        archive.extractall(folder, filter="data")
    return folder / found[0].name.removesuffix(".tar.gz")


@pytest.mark.slow
def test_the_tests_of_py_trees_pass_when_the_engine_ticks(upstream: Path) -> None:
    # This one measures set-up by the wall clock, which a busy machine doesn't keep to, and ticks nothing.
    timing = "--deselect=tests/test_tree.py::test_tree_setup"
    command = [sys.executable, "-m", "pytest", "-q", "-s", "-p", "ticking_by_engine", "-p", "no:cacheprovider", timing]
    command.append("tests")
    done = subprocess.run(
        command,
        cwd=upstream,
        env={**os.environ, "PYTHONPATH": str(HERE)},
        capture_output=True,
        text=True,
        timeout=900,
    )
    text = done.stdout + done.stderr
    assert done.returncode == 0, text[-3000:]
    ticks, passed = re.search(r"ticks by engines: (\d+)", text), re.search(r"(\d+) passed", text)
    assert ticks is not None
    assert int(ticks[1]) > 400, "the engine did the ticking"
    assert passed is not None
    assert int(passed[1]) > 200, text[-500:]
