"""The direct solution of TOPP-RA gives what the library `toppra` gives, and keeps the limits."""

import numpy as np
import pytest
import toppra
import toppra.algorithm
import toppra.constraint

from grip_bt.commanders.trajectory.timing import _curve, squared_velocities


def ours(rows, points, velocity, acceleration):
    at, spline = _curve(rows)
    grid = np.linspace(0.0, at[-1], points)
    return grid, squared_velocities(grid, spline(grid, 1), spline(grid, 2), velocity, acceleration)


def of_the_library(rows, grid, velocity, acceleration):
    """Return the largest squared path velocities from rest to rest, as `toppra` finds them."""
    toppra.setup_logging("ERROR")
    knots, path = _curve(rows)
    limits = [
        toppra.constraint.JointVelocityConstraint(np.stack([-velocity, velocity], axis=1)),
        toppra.constraint.JointAccelerationConstraint(np.stack([-acceleration, acceleration], axis=1)),
    ]
    ends = ((1, path(knots[0], 1)), (1, path(knots[-1], 1)))  # with these it is the same curve
    curve = toppra.SplineInterpolator(knots, path(knots), bc_type=ends)
    method = toppra.algorithm.TOPPRA(limits, curve, gridpoints=grid, parametrizer="ParametrizeConstAccel")
    assert method.compute_trajectory(0, 0) is not None
    return np.asarray(method.problem_data.sd_vec) ** 2


@pytest.mark.parametrize("seed", range(30))
def test_velocities_along_random_paths_are_those_of_the_library(seed):
    rng = np.random.default_rng(seed)
    joints = int(rng.integers(1, 15))
    rows = np.cumsum(rng.uniform(-1, 1, (int(rng.integers(2, 12)), joints)) * rng.uniform(0.02, 1), axis=0)
    velocity, acceleration = rng.uniform(0.2, 3, joints), rng.uniform(0.2, 15, joints)
    grid, found = ours(rows, int(rng.integers(40, 250)), velocity, acceleration)
    expected = of_the_library(rows, grid, velocity, acceleration)
    assert found == pytest.approx(expected, rel=1e-4, abs=1e-5 * expected.max())


def test_joints_that_stand_still_or_turn_back_limit_nothing_they_should_not():
    bend = np.sin(np.linspace(0, 2 * np.pi, 9))
    rows = np.stack([np.linspace(0, 1, 9), bend, np.zeros(9)], axis=1)
    velocity, acceleration = np.ones(3), np.array([2.0, 3.0, 1e-3])
    grid, found = ours(rows, 200, velocity, acceleration)
    assert found == pytest.approx(of_the_library(rows, grid, velocity, acceleration), rel=1e-4, abs=1e-6)


def test_a_straight_line_is_driven_as_a_trapezoid():
    rows = np.array([[0.0], [2.0]])
    grid, found = ours(rows, 201, np.array([0.5]), np.array([1.0]))
    expected = np.minimum(np.minimum(2 * grid, 2 * (2.0 - grid)), 0.25)
    assert found == pytest.approx(expected, abs=1e-9)


def test_the_path_begins_and_ends_at_rest_and_never_rests_between():
    rows = np.cumsum(np.random.default_rng(5).uniform(-1, 1, (8, 6)), axis=0)
    _, found = ours(rows, 300, np.full(6, 0.8), np.full(6, 2.0))
    assert found[0] == found[-1] == 0
    assert (found[1:-1] > 0).all()
