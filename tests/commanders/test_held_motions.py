"""What is left of a motion that was stopped: the same path, from rest; and motions that can't be gone on with."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from timed import ManualClock, OnClock, TimedExecutor, TimedHand

from grip_bt.base.failures import ExecutionAbortedError, SensorError
from grip_bt.base.values import JointState, Trajectory
from grip_bt.commanders.pausing import ASIDE, PausableExecutor, PausableHand, rest_of
from grip_bt.commanders.trajectory.limits import Limits
from grip_bt.commanders.trajectory.timing import timed

NAMES = ("a", "b")
LIMITS = np.array([8.0, 8.0])


def arc(duration: float = 3.0, turns: float = 0.4) -> Trajectory:
    """Along a circle, from rest to rest, with its velocities."""
    part = np.linspace(0, 1, 301)
    angle, rate = (
        2 * np.pi * turns * part**2 * (3 - 2 * part),
        2 * np.pi * turns * 6 * part * (1 - part) / duration,
    )
    return Trajectory(
        NAMES,
        part * duration,
        np.stack([np.cos(angle), np.sin(angle)], axis=1),
        np.stack([-np.sin(angle) * rate, np.cos(angle) * rate], axis=1),
    )


def timed_arc(acceleration: np.ndarray, jerk: np.ndarray) -> Trajectory:
    """Along the same circle, as a planner times it."""
    wide, fast = np.full(2, 99.0), np.full(2, 3.0)
    limits = Limits(-wide, wide, fast, acceleration, jerk)
    return timed(NAMES, arc().positions[::5], limits, lambda _: True)


@given(passed=st.floats(0.0, 3.0), aside=st.floats(-0.04, 0.04), late=st.floats(0.0, 0.3))
def test_the_rest_begins_where_the_joints_are_and_ends_where_the_motion_did(passed: float, aside: float, late: float):
    whole = arc()
    measured = whole.at(max(0.0, passed - late)) + aside
    rest = rest_of(whole, measured, passed, LIMITS)
    assert rest.positions[0] == pytest.approx(measured, abs=0.02 + abs(aside))
    assert rest.positions[0] == pytest.approx(measured, abs=1e-9)
    assert rest.positions[-1] == pytest.approx(whole.positions[-1], abs=1e-9)
    assert rest.duration <= whole.duration - passed + late + 0.6


@given(passed=st.floats(0.0, 2.9))
def test_the_rest_stays_on_the_path_and_begins_at_rest(passed: float):
    whole = arc()
    rest = rest_of(whole, whole.at(passed), passed, LIMITS)
    assert np.linalg.norm(rest.positions, axis=1) == pytest.approx(1.0, abs=1e-3), "on the circle"
    assert rest.velocities is not None
    assert np.abs(rest.velocities[0]).max() < 1e-9
    assert np.abs(rest.velocities).max() <= np.abs(whole.velocities).max() + 1e-9, "no faster than before"
    steps = np.diff(rest.positions, axis=0) / np.diff(rest.times)[:, None]
    between = (rest.velocities[1:] + rest.velocities[:-1]) / 2
    assert np.abs(steps - between).max() < 0.06, "the velocities are those of the positions"


def test_a_path_that_crosses_itself_is_gone_on_with_where_the_time_says():
    to_and_fro = np.concatenate([np.linspace(0, 1, 101), np.linspace(1, 0, 101)[1:]])[:, None]
    whole = Trajectory(("a",), np.linspace(0, 4, 201), to_and_fro)
    assert rest_of(whole, np.array([0.5]), 1.1, LIMITS[:1]).positions.max() == pytest.approx(1.0, abs=0.01)
    assert rest_of(whole, np.array([0.5]), 3.1, LIMITS[:1]).positions.max() == pytest.approx(0.5, abs=0.01)


def test_joints_that_were_moved_meanwhile_end_the_motion():
    clock = ManualClock()
    fake = TimedExecutor(JointState(NAMES, [1.0, 0.0]), OnClock(clock))
    held = PausableExecutor(fake)
    operation = held.execute(arc())
    clock.advance(1.0)
    held.pause()
    clock.advance(2.0)
    fake._position = fake._position + 5 * ASIDE
    held.resume()
    with pytest.raises(ExecutionAbortedError, match="the joints moved during the pause: they are 0."):
        operation.result()


def test_joints_of_which_nothing_is_known_any_more_end_the_motion(monkeypatch: pytest.MonkeyPatch):
    clock = ManualClock()
    fake = TimedExecutor(JointState(NAMES, [1.0, 0.0]), OnClock(clock))
    held = PausableExecutor(fake)
    operation = held.execute(arc())
    clock.advance(1.0)
    held.pause()
    clock.advance(2.0)

    def nothing() -> Any:
        raise SensorError("/joint_states: nothing about a")

    monkeypatch.setattr(fake, "state", nothing)
    held.resume()
    with pytest.raises(ExecutionAbortedError, match="the motion was paused, and /joint_states: nothing about a"):
        operation.result()


def test_fingers_are_held_and_close_on_what_they_closed_on():
    clock = ManualClock()
    names, thing = ("f",), JointState(("f",), [0.6])
    fake = TimedHand(JointState(names, [0.0]), OnClock(clock), thing)
    hand = PausableHand(fake)
    operation = hand.move(JointState(names, [1.0]), 1.0, 0.5)
    clock.advance(0.3)
    hand.pause()
    clock.advance(100.0)
    assert hand.state().position == pytest.approx([0.3 + 0.5 / 40], abs=0.002)
    assert not operation.done()
    hand.resume()
    clock.advance(1.0)
    assert operation.result().position == pytest.approx([0.6])
    assert hand.contacts() == {"fingertip": 5.0}
    assert fake.torque_limits == [0.5, 0.5]


@settings(max_examples=6, deadline=None)
@given(st.floats(0.05, 2.9), st.floats(0.0, 1.0), st.floats(0.3, 40.0), st.booleans())
def test_with_limits_of_jerk_nothing_is_beyond_them_from_the_start_over_pauses_to_the_end(when, rests, sharp, again):
    """What joints do at 1 kHz: a motion, held at any moment, gone on with, and held once more."""
    clock, jerks = ManualClock(), {name: 60.0 + 10 * sharp for name in NAMES}
    limits = {name: 8.0 for name in NAMES}
    fake = TimedExecutor(JointState(NAMES, [1.0, 0.0]), OnClock(clock), accelerations=limits, jerks=jerks)
    held = PausableExecutor(fake, limits, clock.now, jerks)
    motion = timed_arc(np.full(2, 8.0), np.array(list(jerks.values())))
    operation, rows = held.execute(motion), [fake.state().position]

    def seen(seconds: float) -> None:
        for _ in range(round(seconds * 1000)):
            clock.advance(0.001)
            rows.append(fake.state().position)

    seen(round(when * motion.duration / 3.0, 3))
    for _ in range(1 + again):
        held.pause()
        seen(0.8 + round(rests / 5, 3))
        held.resume()
        seen(0.25)
    for _ in range(60):
        seen(0.0 if operation.done() else 0.1)
    assert operation.result().position == pytest.approx(motion.positions[-1], abs=1e-6)
    positions = np.stack(rows)
    accelerations = np.diff(positions, 2, axis=0) * 1e6
    assert (np.abs(accelerations) / 8.0).max() <= 1.0 + 1e-3
    assert (np.abs(np.diff(positions, 3, axis=0)) * 1e9 / list(jerks.values())).max() <= 1.0 + 1e-2
