"""Trajectories that somebody else timed are refused exactly where controllers would draw them beyond limits."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly

from grip_bt.base.failures import OutOfLimitsError
from grip_bt.base.values import Trajectory
from grip_bt.commanders.trajectory.limits import ROUNDED, Limits, refuse_beyond_limits

FAR = 1e9


def random_trajectory(rng, joints):
    """From rest to rest, through points with velocities, and with accelerations every second time."""
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 1.0, rng.integers(1, 7)))])
    size = (len(times), joints)
    derivatives = [rng.normal(0.0, spread, size) for spread in (0.5, 2.0)][: rng.integers(1, 3)]
    derivatives[0][[0, -1]] = 0.0
    rows = np.cumsum(rng.normal(0.0, 0.3, size), axis=0)
    return Trajectory(tuple(f"j{k}" for k in range(joints)), times, rows, *derivatives)


def drawn(trajectory, order, times):
    """What a controller draws, or a derivative of it, by scipy: shape (m, n)."""
    rows = (trajectory.positions, trajectory.velocities, trajectory.accelerations)
    values = np.stack([part for part in rows if part is not None], axis=1)
    return BPoly.from_derivatives(trajectory.times, values).derivative(order)(times)


def refused(trajectory, limits):
    try:
        refuse_beyond_limits(trajectory, limits)
    except OutOfLimitsError as error:
        return error
    return None


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 7), st.sampled_from([0, 1, 2]), st.floats(0.5, 1.5))
def test_it_is_refused_if_and_only_if_a_sample_of_another_interpolation_is_beyond_a_limit(seed, joints, order, part):
    """One of the limits is some part of what the trajectory needs; the others are far away."""
    assume(abs(part - 1.0) > 0.01)
    trajectory = random_trajectory(np.random.default_rng(seed), joints)
    points = trajectory.times
    times = np.concatenate([np.linspace(0.0, points[-1], 20_001), points[:-1], points[1:] - 1e-9])
    found = drawn(trajectory, order, times)
    lower, upper = found.min(axis=0), found.max(axis=0)
    most = np.maximum(np.abs(found).max(axis=0), 1e-6)
    wide, middle = (upper - lower) / 2, (upper + lower) / 2
    assume(wide.max() > 0.1)
    limits = [np.full(joints, -FAR), np.full(joints, FAR), np.full(joints, FAR), np.full(joints, FAR)]
    if order == 0:
        limits[:2] = middle - wide * part, middle + wide * part
    else:
        limits[order + 1] = most * part
    error = refused(trajectory, Limits(*limits))
    assert (error is not None) == (part < 1.0)
    if error is not None:
        (name,) = error.data["joints"]
        column = trajectory.names.index(name)
        there = drawn(trajectory, order, np.array([error.data["time"]]))[0, column]
        assert error.data["value"] == pytest.approx(there, rel=1e-3, abs=1e-3)
        assert name in str(error)
        assert abs(error.data["value"] - error.data["limit"]) > 0


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.05, 0.95), st.floats(0.05, 0.95))
def test_made_as_much_longer_as_the_refusal_says_it_is_taken(seed, velocity, acceleration):
    trajectory = random_trajectory(np.random.default_rng(seed), 3)
    times = np.linspace(0.0, trajectory.duration, 5001)
    fastest, hardest = (np.maximum(np.abs(drawn(trajectory, k, times)).max(axis=0), 1e-3) for k in (1, 2))
    limits = Limits(np.full(3, -FAR), np.full(3, FAR), fastest * velocity, hardest * acceleration)
    error = refused(trajectory, limits)
    assert error is not None
    longer = float(str(error).split("give its points ")[1].split()[0])
    assert refused(trajectory.stretched(trajectory.duration * longer), limits) is None
    assert refused(trajectory.stretched(trajectory.duration * longer * 0.99), limits) is not None


def test_the_tolerance_is_a_thousandth_and_a_standing_arm_has_none_to_spare():
    limits = Limits(*(np.array([value]) for value in (-1.0, 1.0, 2.0, FAR)))
    for part, taken in ((1.0, True), (1.0 + ROUNDED / 2, True), (1.0 + 2 * ROUNDED, False)):
        times, velocities = [0.0, 0.5, 0.6, 1.1], np.array([[0.0], [2.0], [2.0], [0.0]]) * part
        rows = np.array([[-0.6], [-0.1], [0.1], [0.6]]) * part
        assert (refused(Trajectory(("j",), times, rows, velocities), limits) is None) is taken
    assert refused(Trajectory(("j",), [0.0], [[1.0]]), limits) is None
    assert "position of j = 1.200" in str(refused(Trajectory(("j",), [0.0], [[1.2]]), limits))


@pytest.mark.parametrize("row", [0, 1])
def test_it_has_to_begin_and_end_at_rest(row):
    limits = Limits(*(np.array([value]) for value in (-1.0, 1.0, 2.0, 100.0)))
    velocities = np.zeros((2, 1))
    velocities[row] = 0.02
    error = refused(Trajectory(("j",), [0.0, 1.0], [[0.0], [0.1]], velocities), limits)
    assert "at rest" in str(error)
    assert error.data["time"] == row


def test_what_is_not_a_number_is_refused():
    limits = Limits(*(np.array([value]) for value in (-1.0, 1.0, 2.0, 100.0)))
    for row in range(2):
        given = np.zeros((2, 3, 1))
        given[row, 1] = np.nan
        assert refused(Trajectory(("j",), [0.0, 1.0, 2.0], *given), limits) is not None
