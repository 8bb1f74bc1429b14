"""When joints are at rest: by where they are measured, and when that was; no clock of ours takes part in it."""

from __future__ import annotations

from collections import deque

import numpy as np

from grip_bt.base.values import JointState

STILL = 0.01
"""Joints slower than this are at rest [rad/s or m/s], as for joint_trajectory_controller."""
OVER = 0.1
"""For so long by the stamps of what is measured [s]."""
TOLD = 0.05
"""Velocities that are published are noisy: only larger ones tell that a joint moves [rad/s or m/s]."""


class Stillness:
    """Judges measurements one after the other.

    Attributes:
        moving: which joint moves, and how fast [rad/s or m/s], by the last measurement; empty before the second one.
    """

    def __init__(self) -> None:
        self._seen: deque[JointState] = deque()
        self.moving = ""

    def see(self, state: JointState) -> bool:
        """Tell whether joints have been at rest for `OVER` until a measurement; one that isn't newer tells nothing."""
        if self._seen and state.time <= self._seen[-1].time:
            return False
        self._seen.append(state)
        while len(self._seen) > 2 and state.time - self._seen[1].time >= OVER:
            self._seen.popleft()
        passed = state.time - self._seen[0].time
        if passed < OVER:
            return False
        positions = np.stack([one.position for one in self._seen])
        speeds = np.ptp(positions, axis=0) / passed
        if state.velocity is not None:
            speeds = np.maximum(speeds, np.where(np.abs(state.velocity) > TOLD, np.abs(state.velocity), 0.0))
        worst = int(speeds.argmax())
        self.moving = f"{state.names[worst]} at {speeds[worst]:.3f} a second"
        return bool(speeds[worst] <= STILL)
