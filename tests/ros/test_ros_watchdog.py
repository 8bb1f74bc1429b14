"""A run whose process was killed leaves nothing moving: its watchdog, which outlives it, has the robot hold."""

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

from grip_bt.base.interpreter import python_command
from grip_bt.ros.command import child_environment
from grip_bt.ros.watchdog import REPORT

pytestmark = [pytest.mark.ros, pytest.mark.slow]
NAMES = ("joint_a", "joint_b")


@pytest.fixture
def states(bus, start_server, interface_cache):
    from patient_bus import joints_of

    from grip_bt.ros.interfaces.build import ensure_package

    start_server(
        "controller_server.py", overlays=[*ensure_package("control_msgs"), *ensure_package("controller_manager_msgs")]
    )
    made = joints_of(bus, (*NAMES, "finger"))
    until(lambda: np.abs(ended(made.fresh(NAMES)).position).max() < 1e-6)
    return made


def said_of(domain, program, *arguments, overlays=(), begun=lambda: True, later=0.0):
    """Kill a program of `data/` when it has something moved, or so much later [s]; return what its watchdog says."""
    reads, writes = os.pipe()
    with subprocess.Popen(
        python_command(str(DATA / program), *arguments),
        env={**child_environment(overlays, domain), REPORT: str(writes)},
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
            until(begun, within=PATIENCE)
            time.sleep(later + random.uniform(0.0, 0.5))  # any moment will do
        finally:
            os.killpg(run.pid, signal.SIGKILL)
    with os.fdopen(reads) as report:
        return json.loads(report.read() or "null")


@pytest.mark.parametrize(("way", "later"), [("trajectory", 0.0), ("trajectory", 1.5), ("topic", 0.0)])
def test_the_arm_of_a_run_that_was_killed_comes_to_rest(way, later, states, domain):
    begun = lambda: np.abs(ended(states.fresh(NAMES)).position).max() > 1e-4  # noqa: E731
    said = said_of(domain, "mover.py", way, str(domain), begun=begun, later=later)
    assert said == ({"arm": ""} if way == "trajectory" else None), "set-points end with who sends them"
    there = stands(states, NAMES)
    assert np.abs(there).max() < 2.0
    assert ended(states.fresh(NAMES)).position == pytest.approx(there, abs=1e-3)


def test_a_run_that_has_ended_its_motions_leaves_no_watchdog(domain):
    from grip_bt.ros.watchdog import Watchdog

    with Watchdog(domain) as watchdog:
        watchdog.goal_sent("/act", bytes(16))
        watchdog.goal_ended(bytes(16))
        pid = watchdog._process.pid
    until(lambda: gone(pid), within=PATIENCE)


COMPONENT = """\
name: worker
interface: trial_interfaces/action/Work
server: /work
outcomes: [done]
moves: {moves}
timeouts: {{call: 1000, ready: 400, cancel: 400}}
"""


@pytest.fixture
def counts(bus, act, trial):
    """Start a server that isn't the run's, and return a function that gives its counts."""
    from std_srvs.srv import Trigger

    act()
    client = bus.service(Trigger, "/work/counts")
    return lambda: json.loads(ended(client.call(Trigger.Request())).message)


@pytest.fixture
def said_of_a_caller(counts, trial, domain, tmp_path):
    """Return a function that kills a program with a goal of the server's under way; see `data/caller.py`."""

    def said(way, text, moves="true", limit=2 * PATIENCE):
        folder = tmp_path / "components" / "worker"
        folder.mkdir(parents=True)
        (folder / "component.yaml").write_text(COMPONENT.format(moves=moves))
        arguments = ("caller.py", way, str(domain), str(tmp_path), text, str(limit))
        return said_of(domain, *arguments, overlays=[trial], begun=lambda: counts()["active"])

    return said


@pytest.mark.parametrize("moves", ["true", "false"])
def test_a_goal_of_a_component_ends_with_its_run_unless_it_moves_nothing(moves, said_of_a_caller, counts):
    assert said_of_a_caller("component", "slow", moves) is None  # nothing that couldn't be confirmed
    assert counts()["canceled" if moves == "true" else "active"] == 1


def test_a_goal_of_a_smach_state_ends_with_its_run(said_of_a_caller, counts):
    assert said_of_a_caller("state", "slow") is None
    assert counts()["canceled"] == 1


@pytest.mark.parametrize(("how", "why"), [("stubborn", "refused to stop"), ("hang", "the goal did not end")])
def test_a_goal_that_does_not_end_is_told(how, why, said_of_a_caller):
    said = said_of_a_caller("state", how, limit=30.0)  # which is waited for
    assert list(said) == ["/work"]
    assert why in said["/work"]
