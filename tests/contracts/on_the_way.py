"""Motions that are looked at in their middle, and joints that are looked at when they have come to rest.

Where time is the wall's, a busy machine looks late. So motions that are stopped, held or replaced would take much
longer than that to end by themselves, and a rest is one by the times at which the joints were measured.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from patience import PATIENCE

from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState, Trajectory

SLOW = 20.0
"""How long a motion takes whose end isn't waited for [s]."""
EARLY = 0.05
"""How much of its way such a motion has come when it is looked at."""


def towards(rig: Any, duration: float = 1.0, smooth: bool = True) -> Trajectory:
    """Return a way to the rig's goal from where its joints are; one that isn't smooth has its full speed at once."""
    names = rig.port.joint_names
    start, goal = rig.port.state().ordered(names), rig.goal.ordered(names)
    part = np.linspace(0, 1, 41)
    passed = part * part * (3 - 2 * part) if smooth else part
    return Trajectory(names, part * duration, start + (goal - start) * passed[:, None])


def begun(rig: Any) -> tuple[Trajectory, Operation[JointState]]:
    """Begin a slow motion towards the rig's goal, and return it when the joints are seen on their way."""
    trajectory = towards(rig, SLOW, smooth=False)
    operation = rig.port.execute(trajectory)
    let_come(rig, trajectory, EARLY)
    assert not operation.done()
    return trajectory, operation


def came(rig: Any, trajectory: Trajectory) -> float:
    """Return how much of the way the first joint has come, 0 to 1."""
    start, end = trajectory.positions[0][0], trajectory.positions[-1][0]
    return float((rig.port.state().ordered(trajectory.names)[0] - start) / (end - start))


def let_come(rig: Any, trajectory: Trajectory, part: float) -> None:
    """Let time pass until so much of the way is done."""
    passed = 0.0
    while came(rig, trajectory) < part:
        assert passed < PATIENCE, "the joints don't move"
        rig.let_pass(0.05)
        passed += 0.05


def let_stand(rig: Any) -> NDArray[np.float64]:
    """Let time pass until the joints stand, and return where, in the order of the port's state; shape (n,)."""
    passed, before = 0.0, rig.port.state()
    while True:
        rig.let_pass(0.3)
        passed += 0.3
        assert passed < PATIENCE, "the joints don't stand"
        now = rig.port.state()
        if now.time - before.time < 0.25:
            continue  # nothing was measured meanwhile
        if np.abs(now.position - before.position).max() < 1e-3:
            return np.asarray(now.position)
        before = now
