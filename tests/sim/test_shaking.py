"""The referee's word on a shake: which motions of a hand are one, and what has stayed in it meanwhile."""

from __future__ import annotations

import numpy as np
import pytest

from grip_bt.base.values import Pose
from grip_sim.shaking import ShakeConfig, Shaking

STEP = 1 / 240
SAID = ShakeConfig()


class Hand:
    """A hand that is moved about, and a thing in it."""

    def __init__(self):
        self.time, self.place, self.thing = 0.0, np.zeros(3), Pose()
        self.watch = Shaking(SAID, lambda: self.place, self.held)

    def held(self):
        return {"thing": (self.thing.position.tolist(), self.thing.quaternion.tolist())} if self.thing else {}

    def follow(self, ways):
        for way in ways:
            self.place = np.asarray(way)
            self.time += STEP
            if self.time >= self.watch.due:
                self.watch.look(self.time)
        return self.watch.count

    def swing(self, axis, amplitude=SAID.amplitude, frequency=SAID.frequency, seconds=SAID.seconds):
        """Swing as `arm/shake` does: a period for growing, and one for sinking."""
        period, here = 1 / frequency, self.place
        times = np.arange(0.0, seconds + 2 * period, STEP)
        grown = np.clip(np.minimum(times, times[-1] - times) / period, 0, 1)
        way = amplitude * grown**2 * (3 - 2 * grown) * np.sin(2 * np.pi * frequency * times)
        return self.follow(here + np.outer(way, np.eye(3)[axis]))

    def lift(self, height=0.2, seconds=1.0):
        return self.follow(self.place + np.outer(np.linspace(0, height, int(seconds / STEP)), np.eye(3)[2]))


@pytest.fixture
def hand():
    made = Hand()
    made.lift()
    return made


def test_what_stays_in_the_hand_along_all_three_axes_is_held_through_the_shake(hand):
    assert [hand.swing(axis) for axis in range(3)] == [0, 0, 1]


@pytest.mark.parametrize("less", [{"amplitude": 0.7 * SAID.amplitude}, {"frequency": 0.7 * SAID.frequency}])
def test_a_shake_that_is_weaker_than_what_the_world_says_is_none(hand, less):
    assert [hand.swing(axis, **less) for axis in range(3)] == [0, 0, 0]


def test_lifting_and_carrying_is_no_shake(hand):
    for height in (0.2, -0.2, 0.2, -0.2):
        assert hand.lift(height, 0.3) == 0


def test_an_arms_overshoot_before_the_object_was_taken_is_no_part_of_the_shake(hand):
    hand.thing = Pose([0.2, 0, 0])
    stroke = 0.5 * (1 - np.cos(np.linspace(0, np.pi, 60))) * 2 * SAID.amplitude
    hand.follow(np.outer(np.concatenate([stroke, stroke[::-1][:20]]), np.eye(3)[0]) + hand.place)
    hand.thing = Pose()
    hand.follow([hand.place] * 60)
    assert [hand.swing(axis) for axis in range(3)] == [0, 0, 1]


def test_one_axis_is_not_enough(hand):
    assert [hand.swing(0) for _ in range(4)] == [0] * 4


@pytest.mark.parametrize(
    "moved",
    [Pose([1.1 * SAID.shift, 0, 0]), Pose(quaternion=[np.cos(0.55 * SAID.turn), np.sin(0.55 * SAID.turn), 0, 0])],
    ids=["shifted", "turned"],
)
def test_what_moves_further_in_the_hand_than_the_world_says_was_not_held_even_when_it_comes_back(hand, moved):
    hand.swing(0)
    hand.thing = moved
    hand.swing(1)
    hand.thing = Pose()
    assert hand.swing(2) == 0


def test_what_is_dropped_after_the_shake_is_not_held_any_more(hand):
    assert [hand.swing(axis) for axis in range(3)][-1] == 1
    hand.thing = Pose([0, 0, -0.5])
    assert hand.follow([hand.place] * 10) == 0


def test_what_is_taken_away_after_the_shake_is_not_held_any_more(hand):
    assert [hand.swing(axis) for axis in range(3)][-1] == 1
    hand.thing = None
    assert hand.follow([hand.place] * 10) == 0


def test_a_later_shake_is_judged_by_itself(hand):
    hand.thing = Pose([1, 0, 0])
    for axis in range(3):
        hand.swing(axis)
    hand.thing = Pose()
    hand.follow([hand.place] * int(3 / STEP))
    assert [hand.swing(axis) for axis in range(3)] == [0, 0, 1]
