"""How long a robot over ROS moves on when a run is killed: real processes, `kill -9` at random moments.

.venv/bin/python benchmarks/killed_runs.py [ROUNDS] [SEED]

`grip sim` serves a Panda with an Allegro hand. `grip run --robot ros` sends its arm to and fro, without an end. In turn
the run's own process, its parent, and both at once are killed while the arm moves. Printed are the speed of the fastest
joint then, how long braking at the joints' acceleration limits takes from there, and when the joints were measured to
be at rest, in seconds after the kill.
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from contextlib import suppress
from pathlib import Path

import numpy as np

from grip_bt.base.interpreter import python_command
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.client.topic import Received
from grip_bt.ros.command import child_environment
from grip_bt.ros.environment import free_domain

ROUNDS, SEED = int((sys.argv[1:] or ["30"])[0]), int((sys.argv[2:] or ["0"])[0])
REST, MOVES, STILL, LONG = 0.02, 0.1, 0.5, 20.0
"""Joints rest below this speed, as in `stopping.py`, and move above this one [rad/s]; for so long, at most so long."""
ACCELERATIONS = np.array([7.5, 3.75, 5.0, 6.25, 7.5, 10.0, 10.0])
ARM = [f"panda_joint{k}" for k in range(1, 8)]
PROJECT = """grip: 1
robot: panda_allegro
arms: {right: {group: arm, hand: right_hand, planning_time: 60, speed: 1.0}}
hands: {right_hand: {group: hand}}
world: table
ros:
  ready: 200
  stale: 20
  controllers:
    right: {trajectory: /right_controller/follow_joint_trajectory}
    right_hand: {trajectory: /right_hand_controller/follow_joint_trajectory}
"""
TAUGHT = "right:\n" + "".join(
    f"  {name}: {{state: {{{', '.join(f'{j}: {v}' for j, v in zip(ARM, values, strict=True))}}}}}\n"
    for name, values in (
        ("here", (-1.5, -0.44, -0.76, -2.25, 1.31, 1.73, -0.34)),
        ("there", (1.5, -0.44, 0.76, -2.25, 1.31, 1.73, -0.34)),
    )
)
TASK = """grip: 1
name: to_and_fro
root:
  kind: repeat
  times: 100000
  child:
    turn:
      kind: sequence
      children:
        here: {node: arm/move_to, with: {state: here}}
        there: {node: arm/move_to, with: {state: there}}
"""


class Watcher:
    """Measures the arm, by whoever publishes it."""

    def __init__(self, bus: Bus):
        self.samples: list[tuple[float, np.ndarray]] = []
        bus.reader("sensor_msgs/msg/JointState", "/joint_states").listen(self._heard).wait(30.0)

    def _heard(self, received: Received) -> None:
        message = received.message
        if set(ARM) <= set(message.name):
            row = [message.name.index(name) for name in ARM]
            self.samples.append((received.time, np.array([message.velocity[k] for k in row])))

    def speed(self) -> float:
        """Return the speed of the fastest joint [rad/s]."""
        return float(np.abs(self.samples[-1][1]).max()) if self.samples else 0.0

    def rest_after(self, when: float) -> tuple[float, float, float]:
        """Wait for rest; return speed and time to brake at a moment, and when the joints last moved after it [s]."""
        deadline = when + LONG
        while time.monotonic() < deadline:
            time.sleep(0.05)
            late = [np.abs(v).max() for t, v in self.samples if t > time.monotonic() - STILL]
            if late and time.monotonic() > when + STILL and max(late) < REST:
                break
        then = next(v for t, v in reversed(self.samples) if t <= when)
        moving = [t for t, v in self.samples if t > when and np.abs(v).max() >= REST]
        braking = float((np.abs(then) / ACCELERATIONS).max())
        return float(np.abs(then).max()), braking, max(moving, default=when) - when


def own_process(parent: int) -> int:
    """Return the process in which a run executes."""
    for folder in Path("/proc").iterdir():
        with suppress(OSError, ValueError):
            line = (folder / "cmdline").read_bytes()
            if b"grip_bt.app.runs.process" in line:
                above = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
                if above == parent:
                    return int(folder.name)
    raise RuntimeError("the run has no process")


def killed(how: str, folder: Path, domain: int, watcher: Watcher, draw: random.Random) -> tuple[float, float, float]:
    """Kill one run; return what was measured."""
    command = python_command("-m", "grip_bt.cli", "run", str(folder / "task.yaml"), "--robot", "ros", "--watchdog", "0")
    with (folder / "run.txt").open("w") as out:
        run = subprocess.Popen(command, env=child_environment((), domain), stdout=out, stderr=out)
    while watcher.speed() < MOVES:
        if run.poll() is not None:
            raise RuntimeError((folder / "run.txt").read_text())
        time.sleep(0.01)
    pids = {"run": [own_process(run.pid)], "parent": [run.pid], "both": [run.pid, own_process(run.pid)]}[how]
    time.sleep(draw.uniform(0.0, 1.5))
    when = time.monotonic()
    for pid in pids:
        os.kill(pid, signal.SIGKILL)
    found = watcher.rest_after(when)
    run.wait()
    if how == "run":
        sys.stdout.write("    " + (folder / "run.txt").read_text().strip().splitlines()[-1][:300] + "\n")
    return found


def main() -> None:
    """Measure, and print a table."""
    draw = random.Random(SEED)
    with tempfile.TemporaryDirectory() as name, free_domain() as domain:
        folder = Path(name)
        for file, text in (("grip.yaml", PROJECT), ("taught.yaml", TAUGHT), ("task.yaml", TASK)):
            (folder / file).write_text(text)
        served = python_command("-m", "grip_bt.cli", "sim")
        with (folder / "sim.txt").open("w") as out:
            sim = subprocess.Popen(served, cwd=folder, env=child_environment((), domain), stdout=out, stderr=out)
        try:
            while "serving" not in (folder / "sim.txt").read_text():
                time.sleep(0.2)
            with Bus("watcher", domain) as bus:
                watcher, rows = Watcher(bus), defaultdict(list)
                for k in range(ROUNDS):
                    how = ("run", "parent", "both")[k % 3]
                    row = killed(how, folder, domain, watcher, draw)
                    rows[how].append(row)
                    watcher.samples = watcher.samples[-50:]
                    sys.stdout.write(
                        f"{how:<7} {row[0]:6.2f} rad/s  brakes in {row[1]:.3f} s  rest after {row[2]:.3f} s\n"
                    )
                    sys.stdout.flush()
        finally:
            sim.kill()
            sim.wait()
    for how, found in rows.items():
        worst = max(found, key=lambda row: row[2] - row[1])
        beyond = sorted(row[2] - row[1] for row in found)
        sys.stdout.write(
            f"{how:<7} {len(found)} kills: rest {worst[2]:.3f} s after the worst, {beyond[-1]:.3f} s beyond braking"
            f" (median {beyond[len(beyond) // 2]:.3f} s)\n"
        )


if __name__ == "__main__":
    main()
