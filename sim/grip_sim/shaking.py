"""Whether objects stay in a hand while it is shaken: a test of grasps that the task knows nothing of.

Whatever moves the hand, a stroke is its way between two points where it turns back, along an axis of the world. A shake
has enough strokes, long and quick enough, along each axis. How objects lie in the hand is compared with how they lay
when its first stroke began.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.values import Pose
from grip_bt.base.yaml.models import Positive, Settings

MEASURE = "held_through_shake"
SHORT, SLOW = 0.8, 1.25
"""Least length and longest duration of a stroke, as parts of what is asked: arms lag behind their targets. Much
longer ones are of other motions."""
BACK = 0.2
"""A hand that has come back by this part of the amplitude has turned."""
PAUSE = 2.0
"""Strokes that come later than this after the last one belong to another shake [s]."""
PERIOD = 1 / 60
"""Interval between two looks [s]."""


class ShakeConfig(Settings):
    """A shake, and how far an object may move in the hand meanwhile to count as held."""

    amplitude: Positive = 0.025
    """How far the hand goes to each side, along x, y and z of the world [m]."""
    frequency: Positive = 1.5
    """How often it comes and goes [1/s]."""
    seconds: Positive = 1.0
    """How long, along each axis [s]."""
    shift: Positive = 0.03
    """How far the object's centre may move in the hand [m]."""
    turn: Positive = 0.5
    """How far the object may turn in the hand [rad]."""


class _Seen(NamedTuple):
    place: float
    time: float
    held: Callable[[], Mapping[str, Pose]]


class Shaking:
    """Watches a hand, and tells which objects have stayed in it.

    Args:
        look: returns where the hand is, shape (3,) [m], and what computes the pose of each object in it then.
    """

    def __init__(self, said: ShakeConfig, look: Callable[[], tuple[Array, Callable[[], Mapping[str, Pose]]]]):
        self._said, self._look = said, look
        self._turned, self._furthest = list[_Seen](), list[_Seen]()
        self._strokes, self._needed = np.zeros(3, dtype=int), int(2 * said.frequency * said.seconds) - 1
        self._last = self._looked = self._end = -np.inf
        self._stayed: dict[str, Pose] = {}
        """What has stayed in the hand since the shake began, as it lay then."""

    @property
    def count(self) -> int:
        """How many objects were held through the last shake, and still are as they were; 0 before its end."""
        return len(self._stayed) if (self._strokes >= self._needed).all() else 0

    def stepped(self, time: float) -> None:
        """Look at where things are."""
        if time - self._looked < PERIOD:
            return
        hand, held = self._look()
        self._looked, here = time, [_Seen(place, time, held) for place in hand.tolist()]
        self._furthest, self._turned = self._furthest or list(here), self._turned or list(here)
        for axis in range(3):
            self._follow(axis, here[axis])
        if self._stayed:
            stay, now = self._stayed.items(), held()
            self._stayed = {name: before for name, before in stay if self._as_before(before, now[name])}

    def _follow(self, axis: int, here: _Seen) -> None:
        begun, end = self._turned[axis], self._furthest[axis]
        if (here.place - end.place) * (end.place - begun.place) >= 0:
            self._furthest[axis] = here
        elif abs(here.place - end.place) > BACK * self._said.amplitude:
            length = abs(end.place - begun.place) / (2 * self._said.amplitude)
            if SHORT <= length <= 1 / SHORT and end.time - begun.time <= SLOW / (2 * self._said.frequency):
                self._stroke(axis, begun, end.time)
            self._turned[axis], self._furthest[axis] = end, here

    def _stroke(self, axis: int, begun: _Seen, end: float) -> None:
        started = (self._strokes > 0) & (self._strokes < self._needed)
        stray = begun.time != self._end and started.any()  # what came before was an arm's overshoot
        if stray or self._looked - self._last > PAUSE:
            self._strokes[:] = 0
            self._stayed = dict(begun.held())
        self._last, self._end = self._looked, end
        self._strokes[axis] += 1

    def _as_before(self, before: Pose, now: Pose) -> bool:
        turn = 2 * np.arccos(min(abs(float(before.quaternion @ now.quaternion)), 1.0))
        return bool(np.linalg.norm(now.position - before.position) <= self._said.shift and turn <= self._said.turn)
