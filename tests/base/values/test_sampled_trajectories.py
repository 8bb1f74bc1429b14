"""A trajectory between its points is what a joint_trajectory_controller draws."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BPoly

from grip_bt.base.values import Trajectory


@given(st.integers(0, 10**6), st.integers(0, 2), st.integers(1, 5), st.integers(2, 9))
def test_it_is_the_polynomial_of_what_its_points_give(seed, given_too, joints, count):
    rng = np.random.default_rng(seed)
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.01, 1.0, count - 1))])
    rows = rng.normal(size=(3, count, joints))
    names = tuple(f"j{k}" for k in range(joints))
    trajectory = Trajectory(names, times, rows[0], *(rows[k] for k in range(1, given_too + 1)))
    curve = BPoly.from_derivatives(times, rows[: given_too + 1].transpose(1, 0, 2))
    where = np.append(rng.uniform(0.0, times[-1], 20), times[:-1])
    for order, found in enumerate(trajectory.sampled(where)):
        assert found == pytest.approx(curve(where, order), rel=1e-6, abs=1e-6 * 10 ** (2 * order))
    for time in where:
        assert trajectory.at(time) == pytest.approx(curve(time), rel=1e-6, abs=1e-9)


def test_before_and_after_it_the_joints_stand():
    trajectory = Trajectory(("a",), [0.0, 1.0], [[1.0], [2.0]], [[3.0], [4.0]])
    positions, velocities, accelerations = trajectory.sampled(np.array([-1.0, 5.0]))
    assert positions[:, 0].tolist() == [1.0, 2.0]
    assert not velocities.any()
    assert not accelerations.any()
    assert trajectory.at(-1.0).tolist() == [1.0]
    assert trajectory.at(5.0).tolist() == [2.0]


def test_one_point_is_a_place_to_stand():
    trajectory = Trajectory(("a",), [0.0], [[1.0]], [[0.0]])
    assert trajectory.at(0.5).tolist() == [1.0]
    assert trajectory.sampled(np.array([0.0, 2.0]))[0][:, 0].tolist() == [1.0, 1.0]
