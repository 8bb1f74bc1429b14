"""Motions that are changed while a controller follows them, and controllers that know no such thing."""

from __future__ import annotations

import time
from functools import partial

import numpy as np
import pytest
from patience import PATIENCE, until
from ros_bench import ended

from grip_bt.base.failures import CanceledError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Steerable
from grip_bt.commanders.steered_motion import STEP, SteeredMotion, velocity_of
from grip_bt.commanders.steering import steered

pytestmark = [pytest.mark.ros, pytest.mark.slow]
NAMES = ("joint_a", "joint_b")
SPEED = np.array([0.1, -0.07])
SLOW = 0.05 * SPEED
"""As fast as joints may be that a machine which is late by 10 s still finds near to where they were measured."""
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
    """With steps of a second, so that a busy machine changes them in time too."""
    from grip_bt.ros.controllers import StreamedExecutor, TrajectoryExecutor

    if kind == "trajectory":
        executor = TrajectoryExecutor(bus, "/arm/follow_joint_trajectory", NAMES, states, wait=PATIENCE)
    else:
        executor = StreamedExecutor(bus, "/stream/commands", NAMES, states)
    assert isinstance(executor, Steerable)
    until(lambda: executor.steerable, "the topic isn't heard")
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


def test_a_controller_without_a_topic_rests_after_each_step(bus, states):
    from grip_bt.ros.controllers import TrajectoryExecutor

    executor = TrajectoryExecutor(bus, "/untopical/follow_joint_trajectory", NAMES, states, wait=PATIENCE)
    stream, begin = SteeredMotion(executor, plan_step), states.state(NAMES).position
    assert not executor.steerable
    for _ in range(2):
        ended(stream.steer(lambda _: ((*SPEED, 0), (0, 0, 0))))
    assert executor.passed() is None
    assert (states.state(NAMES).position - begin)[0] > 1.8 * STEP * SPEED[0]


def test_a_goal_and_a_steered_motion_take_the_place_of_each_other(bus, states):
    from grip_bt.ros.controllers import TrajectoryExecutor

    executor = TrajectoryExecutor(bus, "/arm/follow_joint_trajectory", NAMES, states, wait=PATIENCE)
    until(lambda: executor.steerable, "the topic isn't heard")
    away = partial(steered, NAMES, velocity=np.zeros(2), wanted=lambda q: SLOW, acceleration=np.full(2, 2.0))
    begin = states.state(NAMES).position
    first = executor.execute(away(position=begin, hold=100.0))
    until(lambda: states.state(NAMES).position[0] > begin[0] + 0.001, "the goal isn't followed")
    second = executor.execute_steered(away(position=states.state(NAMES).position, hold=100.0))
    until(lambda: executor.passed() or second.done(), "the steered motion doesn't begin")
    assert not second.done() or ended(second)  # which raises the reason why it doesn't
    with pytest.raises(CanceledError):
        ended(first)
    third = executor.execute(away(position=states.state(NAMES).position, hold=0.5))
    with pytest.raises(CanceledError):
        ended(second)
    assert ended(third).position == pytest.approx(states.state(NAMES).position, abs=1e-3)
    assert executor.passed() is None
