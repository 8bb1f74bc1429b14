"""`grip doctor` finds what is missing, whatever that is, and `--fix` runs the commands that it offers."""

import os
import shutil
import subprocess
import sys

import pytest

from grip_bt.cli import doctor as module
from grip_bt.cli.__main__ import main

HIDING = """import importlib.metadata
from importlib.machinery import PathFinder
from pathlib import Path

hidden = Path(__file__).with_name("hidden.txt")
find = PathFinder.find_spec


def present(name, path=None, target=None):
    return None if name.partition(".")[0] in hidden.read_text().split() else find(name, path, target)


PathFinder.find_spec = present
"""
PIP = """import sys
from pathlib import Path

print("installs", *sys.argv[1:])
Path(__file__).parents[1].joinpath("hidden.txt").write_text("")
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("hidden", "part", "extras"),
    [("pydantic", "core", "all"), ("toppra", "motion", "motion")],
)
def test_a_library_that_is_missing_is_found_and_installed(hidden, part, extras, tmp_path):
    """Also one that everything else takes."""
    pytest.importorskip(hidden)
    (tmp_path / "sitecustomize.py").write_text(HIDING)
    (tmp_path / "hidden.txt").write_text(hidden)
    (tmp_path / "pip").mkdir()
    (tmp_path / "pip" / "__init__.py").touch()
    (tmp_path / "pip" / "__main__.py").write_text(PIP)

    def doctor(*words):
        command = [sys.executable, "-m", "grip_bt.cli", "doctor", *words]
        environment = os.environ | {"PYTHONPATH": str(tmp_path)}
        return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=600)

    found = doctor()
    assert found.returncode == 1, found.stderr
    assert f"MISS  {part:<12} ModuleNotFoundError: No module named {hidden!r}" in found.stdout
    assert f"pip install 'grip-bt[{extras}]'" in found.stdout
    mended = doctor("--fix")
    command = next(line for line in mended.stderr.splitlines() if line.startswith("$ "))
    assert command.startswith(f"$ {sys.executable} -m pip install ")
    assert extras in command
    assert f"ok    {part}" in mended.stdout


def test_a_compiler_is_installed_for_root_where_apt_is(tmp_path, monkeypatch, capfd):
    for name in ("sh", "cp"):
        (tmp_path / name).symlink_to(shutil.which(name))
    apt = tmp_path / "apt-get"
    apt.write_text(f'#!/bin/sh\necho "apt-get $*"\ncp apt-get {tmp_path}/g++; cp apt-get {tmp_path}/gcc\n')
    apt.chmod(0o755)
    monkeypatch.setattr("grip_bt.cli.doctor._CHECKS", [module._compiler])
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    assert main(["doctor", "--fix"]) == 1
    said = capfd.readouterr()
    assert "fix: sudo apt-get install g++ python3-dev" in said.out
    assert "$" not in said.err
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    assert main(["doctor", "--fix"]) == 0
    assert "$ apt-get install -y g++ python3-dev" in capfd.readouterr().err
    for name in ("g++", "gcc", "apt-get"):
        (tmp_path / name).unlink()
    assert main(["doctor", "--fix"]) == 1
    assert "$" not in capfd.readouterr().err
