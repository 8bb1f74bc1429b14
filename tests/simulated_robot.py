"""`grip sim`, the simulated robot that is served over ROS, in a process of its own as users start it."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

PATIENCE = 240.0
PROJECT = """grip: 1
robot: panda_allegro
arms: {right: {group: arm, hand: right_hand, planning_time: 60}}
hands: {right_hand: {group: hand}}
sensors: {overhead: {camera: overhead}}
world: table
"""
ARM = tuple(f"panda_joint{k}" for k in range(1, 8))
ARM_ACTION = "/right_controller/follow_joint_trajectory"


@dataclass
class World:
    """A running `grip sim`, and the project that reaches it."""

    folder: Path
    domain: int
    process: subprocess.Popen[str]
    log: Path


@contextmanager
def simulated_robot(
    folder: Path, domain: int, *options: str, project: str = PROJECT, world: str = "table"
) -> Iterator[World]:
    """Serve a simulated robot from a folder until the block ends.

    Args:
        folder: gets the project's file; what it says goes to `sim.txt` beside it.
        domain: the DDS domain.
        options: of `grip sim`.
        project: its grip.yaml.
        world: its name.
    """
    from grip_bt.ros.command import child_environment
    from grip_bt.ros.interfaces.build import ensure_package

    ensure_package("control_msgs")
    (folder / "grip.yaml").write_text(project)
    log = folder / "sim.txt"
    command = [sys.executable, "-m", "grip_bt.cli", "sim", world, *options]
    with log.open("w") as out:
        process = subprocess.Popen(
            command, cwd=folder, env=child_environment((), domain), stdout=out, stderr=subprocess.STDOUT, text=True
        )
    deadline = time.monotonic() + PATIENCE
    while (serves := "serving;" in log.read_text()) is False and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.1)
    try:
        assert serves, log.read_text()
        yield World(folder, domain, process, log)
    finally:
        process.kill()
        process.wait()
