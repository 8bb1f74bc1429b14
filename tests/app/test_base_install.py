"""Without any extra, a new project's task is checked, drawn, run over fakes and measured."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

EXTRAS = (
    *("coal", "ompl", "pinocchio", "pytracik", "toppra", "xacro", "eaik", "sapien", "mcap", "fastapi", "uvicorn"),
    *("websockets", "rclpy", "rosidl_adapter", "rosidl_parser", "geometry_msgs", "sensor_msgs", "example_robot_data"),
)
HOOK = """import importlib.metadata
from importlib.machinery import PathFinder

find, distribution = PathFinder.find_spec, importlib.metadata.distribution


def present(name, path=None, target=None):
    return None if name.partition(".")[0] in {names!r} else find(name, path, target)


def installed(name):
    if name.replace("-", "_") in {names!r}:
        raise importlib.metadata.PackageNotFoundError(name)
    return distribution(name)


PathFinder.find_spec, importlib.metadata.distribution = present, installed
"""
CAMPAIGN = "campaign: 1\ntask: tasks/first.yaml\nrobot: fake\nseeds: [0]\n"


@pytest.fixture
def bare(tmp_path: Path):
    """Return a function that runs `grip` in a new project where no extra is installed."""
    (tmp_path / "hook").mkdir()
    (tmp_path / "hook/sitecustomize.py").write_text(HOOK.format(names=EXTRAS))
    environment = os.environ | {"PYTHONPATH": str(tmp_path / "hook")}

    def grip(*words: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "grip_bt.cli", *words]
        folder = tmp_path / "lab" if (tmp_path / "lab").is_dir() else tmp_path
        return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=600)

    assert grip("new", "lab").returncode == 0
    return grip


@pytest.mark.slow
def test_what_needs_no_robot_works_without_extras(bare, tmp_path):
    (tmp_path / "lab/c.yaml").write_text(CAMPAIGN)
    for words in (
        ("check", "tasks/first.yaml"),
        ("convert", "tasks/first.yaml", "--to", "svg", "-o", "first.svg"),
        ("run", "tasks/first.yaml", "--robot", "fake"),
        ("run", "tasks/first.yaml", "--robot", "fake", "--as", "sm"),
        ("bench", "c.yaml"),
        ("runs",),
    ):
        done = bare(*words)
        assert "Traceback" not in done.stderr, (words, done.stderr)
        assert done.returncode == 0, (words, done.stdout, done.stderr)
    told = bare("doctor").stdout
    assert all(part in told for part in ("motion", "simulator", "ros", "editor"))
    assert told.count("fix: ") >= 4


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "extra"),
    [
        (("run", "tasks/first.yaml", "--robot", "sim"), "grip-bt[sim]"),
        (("sim",), "grip-bt[sim,ros]"),
        (("robot", "show", "panda"), "grip-bt[motion]"),
        (("edit", "."), "grip-bt[gui]"),
        (("messages", "list"), "grip-bt[ros]"),
    ],
)
def test_what_needs_an_extra_names_it(bare, words, extra):
    done = bare(*words)
    assert done.returncode in (1, 2), done.stdout + done.stderr
    assert extra in done.stderr + done.stdout
    assert "Traceback" not in done.stderr
