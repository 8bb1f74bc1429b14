"""Changes of a motion that come late: by no delay of any message do the joints go back. Without ROS, in model time."""

from __future__ import annotations

import os

import numpy as np
import pytest
from controller_model import ModelController, ModelExecutor, ModelTime

from grip_bt.base.operation import Operation
from grip_bt.commanders.steered_motion import SteeredMotion, velocity_of
from grip_bt.commanders.steering import steered

NAMES = ("a", "b", "c")
MOTIONS = int(os.environ.get("GRIP_FUZZ_DELAYS", "150"))
BACK = 2e-3
"""What joints may move back at all [rad/s]; they are asked to move at up to 1 rad/s."""


class Steering:
    """An arm that is steered over a controller whose messages take what `delay` says."""

    def __init__(self, delay, rng, planning=lambda: 0.01, acceleration=2.0):
        self.clock, self.rng, self.acceleration = ModelTime(), rng, acceleration
        self.controller = ModelController(NAMES, self.clock, delay)
        self.executor = ModelExecutor(self.controller, self.clock)
        self.planning, self.stream = planning, SteeredMotion(self.executor, self.plan)
        self.motions = []

    def plan(self, start, twist, hold):
        wanted, planned = np.array(twist[0]), Operation()
        limits = np.full(3, self.acceleration)
        step = steered(NAMES, start.position, velocity_of(start, NAMES), lambda q: wanted, limits, hold)
        self.clock.after(self.planning(), lambda: planned.succeed(step))
        return planned

    def go(self, speeds, every=lambda: 0.05):
        """Steer with one velocity after the other, and return the velocities of the joints, shape (k, n)."""
        for speed in speeds:
            self.motions.append(self.stream.steer(lambda _, speed=speed: (speed, np.zeros(3))))
            self.clock.run(self.clock.now() + every())
        self.clock.run(self.clock.now() + 10.0)  # what is under way comes, and comes to rest
        for motion in self.motions:
            motion.result()
        return self.controller.velocities(0.005)


def delays_of(rng):
    """A way that is quick mostly, and sometimes so slow that anything may have happened meanwhile."""
    usual, spread, odd = (
        rng.choice([0.001, 0.005, 0.03, 0.1]),
        rng.choice([0.1, 0.5, 1.0]),
        rng.choice([0.0, 0.05, 0.3]),
    )
    return lambda: (
        rng.uniform(0.1, 2.5) if rng.random() < odd else float(usual * np.exp(spread * rng.standard_normal()))
    )


def directed_motion(seed):
    """Velocities of the joints in the directions in which they were asked to move, whatever the messages took."""
    rng = np.random.default_rng(seed)
    direction = rng.choice([-1.0, 1.0], 3)
    most = rng.choice([0.1, 0.4, 1.0])
    planning = lambda: rng.choice([0.005, 0.02, 0.1, 0.4], p=[0.5, 0.3, 0.15, 0.05])  # noqa: E731
    steering = Steering(delays_of(rng), rng, planning, rng.choice([1.0, 2.0, 8.0]))
    steady = rng.uniform(0, most, 3)
    speeds = [direction * (steady if rng.random() < 0.7 else rng.uniform(0, most, 3)) for _ in range(25)]
    seen = steering.go(speeds, lambda: rng.uniform(0.02, 0.2))
    return seen * direction, most, steering.executor.amended


@pytest.mark.slow
def test_joints_never_go_back_whatever_messages_take():
    amended = 0
    for seed in range(MOTIONS):
        seen, most, changes = directed_motion(seed)
        amended += changes
        assert seen.min() > -BACK, f"seed {seed}: joints went back at {-seen.min():.4f} rad/s"
        assert seen.max() < most * 1.25 + BACK, f"seed {seed}: {seen.max():.3f} rad/s, asked for {most}"
    assert amended > MOTIONS, "hardly any motion was changed"


@pytest.mark.parametrize("late", [0.0, 0.005, 0.02])
def test_a_motion_whose_changes_come_in_time_is_even(late):
    steering = Steering(lambda: late, np.random.default_rng(0))
    seen = steering.go([np.array([0.3, -0.2, 0.0])] * 40)
    assert steering.executor.amended > 5
    steady = seen[80:300, 0]
    assert steady.min() > 0.3 * (0.99 if late <= 0.005 else 0.8)
    assert steady.max() < 0.3 * 1.05
