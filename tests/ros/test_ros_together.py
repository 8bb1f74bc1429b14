"""Several controllers at once: they move together, and what one of them gives up the others don't go on with."""

from __future__ import annotations

import json

import numpy as np
import pytest
from patience import PATIENCE, until
from ros_bench import ended, stands

from grip_bt.base.failures import CanceledError, ExecutionAbortedError
from grip_bt.base.values import Trajectory
from grip_bt.commanders.joined import JoinedExecutor, all_of

pytestmark = [pytest.mark.ros, pytest.mark.slow]
SIDES = {"left": "left_joint", "right": "right_joint"}
JOINTS = tuple(SIDES.values())
LONG = 300.0
"""How long a motion takes whose end is never waited for [s]."""


@pytest.fixture
def sides(bus, start_server):
    """Return what is measured, an executor for each side, and its process: one joint each, with its own controller."""
    from patient_bus import joints_of

    from grip_bt.ros.controllers import TrajectoryExecutor
    from grip_bt.ros.interfaces.build import ensure_package

    overlays = [*ensure_package("control_msgs"), *ensure_package("controller_manager_msgs")]
    processes = {
        side: start_server("controller_server.py", json.dumps({side: {joint: 0.0}}), overlays=overlays)
        for side, joint in SIDES.items()
    }
    states = joints_of(bus, JOINTS)
    made = {}
    for side, joint in SIDES.items():
        made[side] = TrajectoryExecutor(bus, f"/{side}/follow_joint_trajectory", (joint,), states, wait=PATIENCE)
    return states, made, processes


def to(joint: str, goal: float, duration: float) -> Trajectory:
    part = np.linspace(0, 1, 41)[:, None]
    return Trajectory((joint,), part[:, 0] * duration, part * goal)


def whole(executor: JoinedExecutor, duration: float) -> Trajectory:
    part = np.linspace(0, 1, 41)[:, None]
    return Trajectory(executor.joint_names, part[:, 0] * duration, part * [1.5, -0.6])


def test_a_joined_motion_ends_when_the_joints_of_both_controllers_are_at_their_ends(sides):
    _, executors, _ = sides
    joined = JoinedExecutor(*executors.values())
    assert ended(joined.execute(whole(joined, 2.0))).position == pytest.approx([1.5, -0.6], abs=1e-3)


def test_a_joined_motion_is_under_way_at_both_controllers_at_once_and_stopped_at_both(sides):
    """Neither waits for the other one's end, which is minutes away. How far apart they begin is the controllers'."""
    states, executors, _ = sides
    joined = JoinedExecutor(*executors.values())
    operation = joined.execute(whole(joined, LONG))
    until(lambda: np.abs(states.state(JOINTS).position).min() > 1e-3, "one of the joints doesn't move")
    assert not operation.done()
    operation.cancel()
    with pytest.raises(CanceledError):
        ended(operation)
    assert np.abs(stands(states, JOINTS) / [1.5, -0.6]).max() < 0.95


@pytest.mark.parametrize("how", ["given up", "lost", "stopped", "cancelled"])
def test_when_one_side_ends_early_the_other_one_holds(sides, how):
    states, executors, processes = sides
    left = to("left_joint", 4.0, 4.0) if how == "given up" else to("left_joint", 1.0, LONG)
    joints = {"left": left, "right": to("right_joint", 1.0, LONG)}
    operation = all_of({s: lambda s=s: executors[s].execute(joints[s]) for s in SIDES})
    until(lambda: operation.done() or states.state(JOINTS).position[1] > 1e-3, "the right joint doesn't move")
    if how == "lost":
        processes["left"].kill()
    elif how == "stopped":
        executors["left"].stop()
    elif how == "cancelled":
        operation.cancel()
    with pytest.raises(ExecutionAbortedError if how in ("given up", "lost") else CanceledError) as caught:
        ended(operation)
    assert how != "lost" or caught.value.data["cause"] == "server_lost"
    assert stands(states, JOINTS[how == "lost" :])[-1] < 0.95, "the right side went on to its end"
