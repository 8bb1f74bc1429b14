"""Where moving frames were: between two transforms, never beyond them."""

from __future__ import annotations

import numpy as np
import pytest

from grip_bt.base.values import Pose
from grip_bt.ros.frames import KEPT, FrameHistory, between


def about(axis, angle, position=(0, 0, 0), frame="base") -> Pose:
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    return Pose(position, np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * axis]), frame)


def angle_between(one: Pose, other: Pose) -> float:
    return float(np.linalg.norm((one.inverse() @ other).rotation_vector()))


@pytest.mark.parametrize("seed", range(20))
def test_between_two_poses_everything_is_passed_at_an_even_speed_on_the_short_way(seed):
    rng = np.random.default_rng(seed)
    one, other = (Pose(rng.normal(size=3), rng.normal(size=4), "base") for _ in range(2))
    whole = angle_between(one, other)
    assert whole <= np.pi + 1e-9
    for part in np.linspace(0, 1, 7):
        found = between(one, other, float(part))
        assert np.allclose(found.position, (1 - part) * one.position + part * other.position)
        assert angle_between(one, found) == pytest.approx(part * whole, abs=1e-7)
        assert angle_between(found, other) == pytest.approx((1 - part) * whole, abs=1e-7)
        flipped = Pose(other.position, -other.quaternion, "base")
        assert angle_between(found, between(one, flipped, float(part))) == pytest.approx(0, abs=1e-7)


def test_poses_that_are_almost_the_same_are_passed_too():
    one, other = about((0, 0, 1), 0.3), about((0, 0, 1), 0.3 + 1e-9)
    assert angle_between(one, between(one, other, 0.5)) < 1e-8


def test_a_frame_is_known_from_its_first_to_its_last_transform():
    history = FrameHistory()
    for stamp in (2.0, 1.0, 3.0):  # in any order
        history.add("tool", about((0, 0, 1), 0.0, (stamp, 0, 0)), stamp, heard=0.0)
    assert history.spans() == {"tool": (1.0, 3.0)}
    assert history.at(0.99) == history.at(3.01) == {}
    for time in (1.0, 1.25, 2.0, 2.75, 3.0):
        assert history.at(time)["tool"].position[0] == pytest.approx(time)


def test_a_transform_of_the_same_time_replaces_the_one_before():
    history = FrameHistory()
    history.add("tool", Pose((1, 0, 0), frame="base"), 1.0, 0.0)
    history.add("tool", Pose((2, 0, 0), frame="base"), 1.0, 0.0)
    assert history.at(1.0)["tool"].position[0] == 2


def test_transforms_are_kept_for_a_while_and_forgotten_when_time_begins_anew():
    history = FrameHistory()
    for stamp in np.arange(0, 3 * KEPT, 0.5):
        history.add("tool", Pose(frame="base"), float(stamp), 0.0)
    begin, end = history.spans()["tool"]
    assert (begin, end) == (3 * KEPT - 0.5 - KEPT, 3 * KEPT - 0.5)
    history.add("tool", Pose((7, 0, 0), frame="base"), 0.25, 0.0)  # a simulation that was started again
    assert history.spans()["tool"] == (0.25, 0.25)


def test_a_frame_that_hangs_on_another_one_from_now_on_has_no_past_there():
    history = FrameHistory()
    history.add("cup", Pose((1, 0, 0), frame="table"), 1.0, 0.0)
    history.add("cup", Pose((0, 0, 0), frame="hand"), 2.0, 0.0)
    assert history.at(1.5) == {}
    assert history.at(2.0)["cup"].frame == "hand"


def test_what_was_not_heard_of_lately_is_not_known_now():
    history = FrameHistory()
    history.add("old", Pose(frame="base"), 1.0, heard=5.0)
    history.add("new", Pose(frame="base"), 1.0, heard=6.0)
    assert set(history.latest(5.0)) == {"new"}
