"""Waiting until joints that were told to stop are measured at rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from grip_bt.base.failures import SensorError
from grip_bt.base.ports import Context
from grip_bt.base.values import JointState
from grip_bt.commanders.trajectory.limits import RestDetector

LOOK = 0.05
"""How often it is looked at whether they are [s]."""


class Resting:
    """Looks at joints, at each tick and on until they are at rest.

    Args:
        context: of the leaf that waits; it is woken for each look.
        state: measures the joints.
    """

    def __init__(self, context: Context, state: Callable[[], JointState]):
        self._context, self._state = context, state
        self._judge, self._rest = RestDetector(), False

    def reached(self) -> bool:
        """Tell whether the joints were measured at rest; where nothing is measured, they weren't."""
        now = self._context.clock.now()
        if not self._rest:
            try:
                state = self._state()
                self._rest = self._judge.see(state if state.time else replace(state, time=now))
            except SensorError:
                pass
            if not self._rest:
                self._context.wake_at(now + LOOK)
        return self._rest
