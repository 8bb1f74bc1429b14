from dataclasses import replace

import numpy as np
import pytest
from table_top import named

from grip_bt.base.failures import PathInvalidError
from grip_bt.commanders.trajectory.timing import SAMPLING, timed


def accept_all(trajectory):
    return True


def allowed(limits, speed=1.0, jerk=None):
    return replace(limits, velocity=limits.velocity * speed, acceleration=limits.acceleration * speed, jerk=jerk)


@pytest.fixture
def limits(model):
    return model.limits("arm")


def random_path(model, seed, corners=4):
    rng = np.random.default_rng(seed)
    home = named(model, "arm", "home").position
    return home + np.cumsum(rng.uniform(-0.3, 0.3, (corners, 7)), axis=0)


def names(count=7):
    return tuple(f"joint_{k}" for k in range(count))


def test_a_trajectory_begins_and_ends_at_rest_at_the_paths_ends(model, limits):
    path = random_path(model, 1)
    trajectory = timed(names(), path, allowed(limits, 0.5), accept_all)
    assert trajectory.positions[0] == pytest.approx(path[0])
    assert trajectory.positions[-1] == pytest.approx(path[-1])
    assert trajectory.velocities[[0, -1]] == pytest.approx(np.zeros((2, 7)), abs=1e-12)
    assert np.diff(trajectory.times).max() <= SAMPLING + 1e-9


def test_half_the_speed_takes_longer(model, limits):
    path = random_path(model, 2)
    fast, slow = (timed(names(), path, allowed(limits, speed), accept_all).duration for speed in (1.0, 0.5))
    assert 1.3 * fast < slow < 2.1 * fast


def test_the_spline_stays_near_the_corners_of_the_path(model, limits):
    home = named(model, "arm", "home").position
    path = home + np.array([[0] * 7, [1, *[0] * 6], [1, 1, *[0] * 5]])
    trajectory = timed(names(), path, allowed(limits), accept_all)
    off = trajectory.positions - home
    before, after = np.abs(off[:, 1]), np.abs(off[:, 0] - 1)
    assert np.minimum(before, after).max() < 0.05


def test_knots_are_set_closer_until_the_spline_is_acceptable(model, limits):
    home = named(model, "arm", "home").position
    path = home + np.array([[0] * 7, [1, *[0] * 6], [1, 1, *[0] * 5]])
    seen = []

    def strict(trajectory):
        off = trajectory.positions - home
        seen.append(np.minimum(np.abs(off[:, 1]), np.abs(off[:, 0] - 1)).max())
        return seen[-1] < 0.012

    timed(names(), path, allowed(limits), strict)
    assert len(seen) > 1
    assert seen == sorted(seen, reverse=True)


def test_a_path_that_no_spacing_makes_acceptable_is_refused(model, limits):
    with pytest.raises(PathInvalidError):
        timed(names(), random_path(model, 3), allowed(limits), lambda trajectory: False)


def test_a_path_that_stands_still_takes_no_time(model, limits):
    home = named(model, "arm", "home").position
    trajectory = timed(names(), np.stack([home, home]), allowed(limits), accept_all)
    assert trajectory.duration == 0


def test_positions_never_leave_the_joint_limits(limits):
    edge = (limits.lower + limits.upper) / 2
    edge[1] = limits.upper[1]
    path = np.stack([edge - 0.3, edge, edge - [0.3, 0, 0.3, 0, 0, 0, 0], edge - 0.4])
    trajectory = timed(names(), path, allowed(limits), accept_all)
    assert (trajectory.positions <= limits.upper).all()
    assert (trajectory.positions >= limits.lower).all()
