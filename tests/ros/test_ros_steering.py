"""Motions that are changed while a controller follows them: how even they are, and controllers that don't take it."""

from __future__ import annotations

import time
from functools import partial

import numpy as np
import pytest
from patience import PATIENCE, until
from ros_bench import ended

from grip_bt.base.operation import Operation
from grip_bt.base.ports import Steerable
from grip_bt.commanders.steered_motion import SteeredMotion, velocity_of
from grip_bt.commanders.steering import steered

pytestmark = [pytest.mark.ros, pytest.mark.slow]
NAMES = ("joint_a", "joint_b")
SPEED = np.array([0.1, -0.07])
HOLD = 1.0
"""How long a step holds what is wanted [s]."""


@pytest.fixture
def states(bus, start_server):
    from patient_bus import joints_of

    from grip_bt.ros.interfaces.build import ensure_package

    start_server(
        "controller_server.py", overlays=[*ensure_package("control_msgs"), *ensure_package("controller_manager_msgs")]
    )
    return joints_of(bus, NAMES)


def plan_step(start, twist, hold):
    """A step towards `SPEED`, whatever the twist: these joints have no hand."""
    wanted = np.array(twist[0][:2])
    step = steered(NAMES, start.position, velocity_of(start, NAMES), lambda q: wanted, np.full(2, 2.0), hold)
    return Operation.finished(step)


@pytest.mark.timeout(900)
@pytest.mark.parametrize("kind", ["trajectory", "stream"])
def test_a_steered_motion_goes_on_and_ends_soon_after_the_last_word(bus, states, kind, monkeypatch):
    """With steps of a second, so that a busy machine changes them in time too. How even it is: `test_late_changes`."""
    from grip_bt.ros.controllers import StreamedExecutor, TrajectoryExecutor

    if kind == "trajectory":
        executor = TrajectoryExecutor(bus, "/arm/follow_joint_trajectory", NAMES, states, wait=PATIENCE)
    else:
        executor = StreamedExecutor(bus, "/stream/commands", NAMES, states)
    assert isinstance(executor, Steerable)
    monkeypatch.setattr("grip_bt.commanders.steered_motion.HOLD", HOLD)
    stream, amended, begin, longest = SteeredMotion(executor, plan_step), [], states.state(NAMES).position, 0
    amend, deadline = executor.amend, time.monotonic() + 5 * PATIENCE
    executor.amend = lambda tail, at: amended.append(amend(tail, at)) or amended[-1]
    # A machine that is late lets the joints come to rest, as it should; then a motion begins anew.
    while longest < 3:
        assert time.monotonic() < deadline, "no motion was gone on with three times"
        amended.clear()
        operation, where = stream.steer(lambda _: ((*SPEED, 0), (0, 0, 0))), []
        while not operation.done():
            where.append(states.state(NAMES).position[0])
            if sum(amended) < 4:
                stream.steer(lambda _: ((*SPEED, 0), (0, 0, 0)))
            time.sleep(0.02)
        measured = ended(operation).position
        assert np.diff(where).min() > -0.002, "the joints went back"
        longest = max(longest, sum(amended))
    way = measured - begin
    assert way[0] / way[1] == pytest.approx(SPEED[0] / SPEED[1], rel=0.05)
    assert measured[0] - where[0] > longest * HOLD * SPEED[0] * 0.9


def test_a_controller_that_refuses_to_change_ends_its_motion_and_is_not_asked_again(bus, states):
    from grip_bt.ros.controllers import TrajectoryExecutor

    executor = TrajectoryExecutor(bus, "/stubborn/follow_joint_trajectory", NAMES, states, wait=PATIENCE)
    begin = states.state(NAMES)
    first = partial(steered, NAMES, velocity=np.zeros(2), wanted=lambda q: SPEED, acceleration=np.full(2, 2.0))
    step = first(position=begin.position, hold=14.0)  # the change comes long before its end
    operation = executor.execute(step)
    until(executor.passed, "the motion doesn't begin")
    row = round(5.0 / 0.02)
    tail = steered(NAMES, step.positions[row], step.velocities[row], lambda q: SPEED, np.full(2, 2.0), 20.0)
    assert executor.amend(tail, 5.0)
    assert ended(operation).position == pytest.approx(step.positions[-1], abs=1e-3)
    assert executor.passed() is None
    again = first(position=states.state(NAMES).position, hold=0.2)
    operation = executor.execute(again)
    assert executor.passed() is None
    assert not executor.amend(tail, 0.2)
    assert ended(operation).position == pytest.approx(again.positions[-1], abs=1e-3)
