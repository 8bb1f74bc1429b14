"""The fastest way along a path: within the limits, from rest to rest, along the very same curve."""

import numpy as np
import pytest

from grip_bt.commanders.trajectory import timing
from grip_bt.commanders.trajectory.limits import Limits
from grip_bt.commanders.trajectory.timing import _curve, _drive
from grip_bt.commanders.trajectory.toppra_alone import toppra


def driven(rows, velocity, acceleration):
    """Return path positions, path velocities there, and path accelerations between, with the curve."""
    at, curve = _curve(rows)
    drive = _drive(at, curve, Limits(-velocity, velocity, velocity, acceleration))
    return curve, drive._ss, drive._velocities, drive._us


@pytest.mark.parametrize("seed", range(30))
def test_velocities_and_accelerations_of_random_paths_keep_their_limits(seed):
    rng = np.random.default_rng(seed)
    joints = int(rng.integers(1, 15))
    rows = np.cumsum(rng.uniform(-1, 1, (int(rng.integers(2, 12)), joints)) * rng.uniform(0.02, 1), axis=0)
    velocity, acceleration = rng.uniform(0.2, 3, joints), rng.uniform(0.2, 15, joints)
    curve, grid, speed, change = driven(rows, velocity, acceleration)
    assert speed[0] == speed[-1] == 0
    assert (speed[1:-1] > 0).all()
    used = [np.abs(curve(grid, 1)) * speed[:, None] / velocity]
    for end in (slice(None, -1), slice(1, None)):
        turning = curve(grid[end], 2) * speed[end, None] ** 2
        used.append(np.abs(curve(grid[end], 1) * change[:, None] + turning) / acceleration)
    most = max(part.max() for part in used)
    assert 0.99 <= most <= 1 + 1e-4, "something is at its limit, and nothing beyond"


def test_joints_that_stand_still_or_turn_back_limit_nothing_they_should_not():
    bend = np.sin(np.linspace(0, 2 * np.pi, 9))
    rows = np.stack([np.linspace(0, 1, 9), bend, np.zeros(9)], axis=1)
    one, two = (
        driven(part, np.ones(part.shape[1]), np.array(acceleration))
        for part, acceleration in ((rows, [2.0, 3.0, 1e-3]), (rows[:, :2], [2.0, 3.0]))
    )
    assert one[2] == pytest.approx(two[2], rel=1e-4, abs=1e-6)


def test_a_straight_line_is_driven_as_a_trapezoid():
    _, grid, speed, _ = driven(np.array([[0.0], [2.0]]), np.array([0.5]), np.array([1.0]))
    assert speed**2 == pytest.approx(np.minimum(np.minimum(2 * grid, 2 * (2.0 - grid)), 0.25), abs=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_what_the_library_is_spared_changes_nothing(seed, monkeypatch):
    """Its own limits and its own choice of a solver come to the same, bit by bit, whatever was timed before."""
    rng = np.random.default_rng(seed)
    rows = np.cumsum(rng.uniform(-0.3, 0.3, (6, 7)), axis=0)
    limits = rng.uniform(0.2, 3, 7), rng.uniform(0.2, 15, 7)
    driven(rows, 2 * limits[0], 3 * limits[1])
    spared = driven(rows, *limits)[1:]

    def whole(made, path, grid):
        velocities = toppra.constraint.JointVelocityConstraint(made[0].vlim)
        accelerations = toppra.constraint.JointAccelerationConstraint(made[1].alim)
        return toppra.algorithm.TOPPRA([velocities, accelerations], path, gridpoints=grid)

    monkeypatch.setattr(timing, "Timing", whole)
    for one, other in zip(spared, driven(rows, *limits)[1:], strict=True):
        assert one.tobytes() == other.tobytes()
