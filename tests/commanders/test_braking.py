"""Coming to rest: on the path, within the limits at every millisecond, no later than braking takes, from any moment."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from grip_bt.base.values import Trajectory
from grip_bt.commanders.trajectory.stopping import (
    ACCELERATION,
    ANY,
    LATER,
    accelerations_of,
    braking_times,
    each_by_itself,
    even_ramp,
    smooth_start,
    stop_ramp,
)

SEEDS = st.integers(0, 10**6)


def made(seed):
    """A smooth motion of some joints from rest to rest, to and fro among them, and limits that it keeps to."""
    rng = np.random.default_rng(seed)
    joints, duration = int(rng.integers(1, 8)), float(rng.uniform(0.3, 6.0))
    times = np.linspace(0, duration, max(3, round(duration / 0.02)))
    part = times / duration
    there, back = rng.uniform(-2, 2, (2, joints))
    way, turn = 10 * part**3 - 15 * part**4 + 6 * part**5, (part * (1 - part)) ** 3 * 64
    speed, turning = 30 * (part - part**2) ** 2, 192 * (part * (1 - part)) ** 2 * (1 - 2 * part)
    change = 60 * part - 180 * part**2 + 120 * part**3
    turned = 384 * part * (1 - part) * (1 - 2 * part) ** 2 - 384 * (part * (1 - part)) ** 2
    motion = Trajectory(
        tuple(f"j{k}" for k in range(joints)),
        times,
        np.outer(way, there) + np.outer(turn, back),
        (np.outer(speed, there) + np.outer(turning, back)) / duration,
        (np.outer(change, there) + np.outer(turned, back)) / duration**2,
    )
    hardest = np.abs(motion.sampled(fine(duration))[2]).max(axis=0)
    return motion, hardest * rng.uniform(1.03, 4.0) + 0.01


def fine(duration: float) -> np.ndarray:
    return np.arange(0.0, duration, 1e-3)


@given(SEEDS, st.floats(0, 1))
def test_a_stop_stays_on_the_path_and_within_the_limits_and_is_soon_over(seed, part):
    motion, limits = made(seed)
    begin = part * motion.duration
    ramp = stop_ramp(motion, begin, limits)
    position, velocity, _ = motion.sampled(np.array([begin]))
    assert ramp.positions[0] == pytest.approx(position[0], abs=1e-9)
    assert ramp.velocities is not None
    assert ramp.velocities[0] == pytest.approx(velocity[0], abs=2e-5)
    assert np.abs(ramp.velocities[-1]).max() == 0.0
    assert ramp.duration <= (np.abs(velocity[0]) / limits).max() * 1.03 + LATER + 1e-6
    if ramp.duration > 0.02:
        positions, _, accelerations = ramp.sampled(fine(ramp.duration))
        assert (np.abs(accelerations) / limits).max() <= 1.0
    else:
        positions = ramp.positions
    path = motion.sampled(np.arange(begin, begin + ramp.duration + 0.002, 0.001))[0]
    away = np.abs(positions[:, None] - path[None]).max(axis=2).min(axis=1)
    assert away.max() < 1e-3 + np.abs(np.diff(path, axis=0)).max(initial=0.0)


@given(SEEDS, st.floats(0, 1))
def test_what_was_stopped_goes_on_to_its_end_within_the_limits(seed, part):
    motion, limits = made(seed)
    rest = smooth_start(motion, part * motion.duration, limits, np.full(len(limits), ANY))
    assert rest.positions[-1] == pytest.approx(motion.positions[-1], abs=1e-9)
    assert rest.velocities is not None
    assert np.abs(rest.velocities[0]).max() < 1e-9
    if rest.duration > 0.04:
        assert (np.abs(rest.sampled(fine(rest.duration))[2]) / limits).max() <= 1.02


@given(st.lists(st.tuples(st.floats(-3, 3), st.floats(0.5, 20)), min_size=1, max_size=7))
def test_braking_evenly_brings_all_joints_to_rest_at_once(joints):
    velocity, limits = (np.array(values) for values in zip(*joints, strict=True))
    ramp = even_ramp([f"j{k}" for k in range(len(joints))], np.zeros(len(joints)), velocity, limits)
    assert ramp.duration == pytest.approx((np.abs(velocity) / limits).max(), rel=0.03, abs=1e-3)
    if ramp.duration > 0:
        assert (np.abs(ramp.sampled(fine(ramp.duration))[2]) <= limits).all()
    assert (ramp.positions[-1] * velocity >= 0).all()


@settings(max_examples=60, deadline=None)
@given(SEEDS, st.floats(0, 1), st.floats(1.0, 4.0))
def test_with_limits_of_jerk_no_acceleration_of_a_stop_jumps_and_it_is_soon_over(seed, part, room):
    motion, limits = made(seed)
    jerks = np.abs(np.diff(motion.sampled(fine(motion.duration))[2], axis=0)).max(axis=0) * 1e3 * room * 1.01 + 1.0
    begin = part * motion.duration
    ramp = stop_ramp(motion, begin, limits, jerks)
    assert ramp.velocities is not None
    assert ramp.accelerations is not None
    if len(ramp.times) > 1:
        drawn = (ramp.positions, ramp.velocities, ramp.accelerations)
        for found, own in zip(drawn, motion.sampled(np.array([begin])), strict=True):
            assert found[0] == pytest.approx(own[0], abs=1e-6)
    assert not ramp.velocities[-1].any()
    assert not ramp.accelerations[-1].any()
    _, velocity, now = motion.sampled(np.array([begin]))
    alone = braking_times(velocity[0], now[0], limits, jerks).max()
    assert ramp.duration <= alone * 1.2 + 0.14
    accelerations = ramp.sampled(fine(ramp.duration))[2]
    if len(accelerations) > 1:
        assert (np.abs(accelerations) / limits).max() <= 1 + 1e-6
        assert (np.abs(np.diff(accelerations, axis=0)) * 1e3 / jerks).max() <= 1 + 1e-6


JOINT = st.tuples(st.floats(-3, 3), st.floats(-1, 1), st.floats(0.5, 20), st.floats(5, 500))
"""Velocity, part of the acceleration limit that it has, limits of acceleration and jerk."""


@given(st.lists(JOINT, min_size=1, max_size=7))
@example([(-1.0, 0.99999, 1.0, 11.0)])
def test_each_joint_by_itself_rests_in_the_time_that_is_said_and_within_its_limits(joints):
    velocity, part, limits, jerks = (np.array(values) for values in zip(*joints, strict=True))
    now = part * limits
    ramp = each_by_itself([f"j{k}" for k in range(len(joints))], np.zeros(len(joints)), velocity, now, limits, jerks)
    soonest = braking_times(velocity, now, limits, jerks)
    assert (soonest >= np.abs(velocity) / limits - 1e-9).all()
    assert (soonest >= np.abs(now) / jerks - 1e-9).all()
    assert soonest.max() - 1e-3 <= ramp.duration <= soonest.max() * 1.2 + 1e-3
    _, speeds, accelerations = ramp.sampled(fine(ramp.duration))
    assert (np.abs(accelerations) <= limits * (1 + 1e-6) + 1e-9).all()
    assert (np.abs(np.diff(accelerations, axis=0)) * 1e3 <= jerks * (1 + 1e-4) + 1e-6).all()
    if len(speeds) > 1:
        assert np.abs(speeds[-1]).max() <= 0.03, "no jump at the end"


def test_a_path_beyond_the_limits_is_left_so_as_to_stop_in_time():
    times = np.linspace(0, 2, 201)
    wave = np.stack([np.sin(10 * times), 3 * times], axis=1)
    speed = np.stack([10 * np.cos(10 * times), np.full(201, 3.0)], axis=1)
    limits = np.array([20.0, 20.0])
    motion = Trajectory(("a", "b"), times, wave, speed)
    for begin in np.linspace(0.1, 1.3, 13):
        ramp = stop_ramp(motion, begin, limits)
        assert ramp.duration <= (np.abs(motion.sampled(np.array([begin]))[1][0]) / limits).max() * 1.03 + LATER
        assert np.abs(ramp.velocities[-1]).max() == 0.0


def test_joints_whose_limits_nobody_says_have_a_stated_one():
    assert accelerations_of(("a", "b"), {"b": 5.0}).tolist() == [ACCELERATION, 5.0]
