"""A run whose process was killed leaves nothing moving: its reaper, which outlives it, has the robot hold."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import time

import numpy as np
import pytest
from patience import PATIENCE, until
from ros_bench import DATA, ended, gone, stands

from grip_bt.interpreter import python_command
from grip_bt.ros.process import child_environment
from grip_bt.ros.reaping import REPORT

pytestmark = [pytest.mark.ros, pytest.mark.slow]
NAMES = ("joint_a", "joint_b")


@pytest.fixture
def states(bus, start_server, interface_cache):
    from patient_bus import joints_of

    from grip_bt.ros.definitions import provide

    start_server("controller_server.py", overlays=[*provide("control_msgs"), *provide("controller_manager_msgs")])
    made = joints_of(bus, (*NAMES, "finger"))
    until(lambda: np.abs(ended(made.fresh(NAMES)).position).max() < 1e-6)
    return made


@pytest.mark.parametrize("way", ["trajectory", "topic"])
def test_the_arm_of_a_run_that_was_killed_comes_to_rest(way, states, domain):
    reads, writes = os.pipe()
    with subprocess.Popen(
        python_command(str(DATA / "mover.py"), way, str(domain)),
        env={**child_environment((), domain), REPORT: str(writes)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        pass_fds=[writes],
        start_new_session=True,
    ) as run:
        os.close(writes)
        try:
            assert run.stdout.readline() == "ready\n"
            run.stdin.write("\n")
            run.stdin.flush()
            assert run.stdout.readline() == "begun\n"
            time.sleep(random.Random(way).uniform(0.0, 0.5))  # any moment will do
        finally:
            os.killpg(run.pid, signal.SIGKILL)
    with os.fdopen(reads) as report:
        said = json.loads(report.readline())
    assert said == {"arm": ""}
    there = stands(states, NAMES)
    assert np.abs(there).max() < 2.0
    assert ended(states.fresh(NAMES)).position == pytest.approx(there, abs=1e-3)


def test_a_run_that_has_ended_its_motions_leaves_no_reaper(domain):
    from grip_bt.ros.reaping import Guard

    with Guard(domain) as guard:
        guard.sent("/act", bytes(16))
        guard.over(bytes(16))
        pid = guard._process.pid
    until(lambda: gone(pid), within=PATIENCE)
