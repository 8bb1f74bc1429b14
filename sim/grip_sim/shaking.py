"""Whether objects stay in a hand while it is shaken: a test of grasps that the task knows nothing of.

Whatever moves the hand, a stroke is its way between two points where it turns back, along an axis of the world. A shake
has enough strokes, long and quick enough, along each axis. How objects lie in the hand is compared with how they lay
when its first stroke had begun.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import acos, dist
from operator import mul
from typing import NamedTuple, TypeAlias

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.yaml.models import Positive, Settings

Lay: TypeAlias = tuple[list[float], list[float]]
"""How an object lies in a hand's frame: its centre [m] and quaternion w x y z."""
MEASURE = "held_through_shake"
SHORT, SLOW = 0.8, 1.25
"""Least length and longest duration of a stroke, as parts of what is asked: arms lag behind their targets. Much
longer ones are of other motions."""
BACK = 0.2
"""A hand that has come back by this part of the amplitude has turned."""
PAUSE = 2.0
"""Strokes that come later than this after the last one belong to another shake [s]."""
LOOKS = 20
"""In a period: a hand's point of return is missed by 1.3 % of the amplitude at most, and falls take longer."""


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
    held: Mapping[str, Lay]


class Shaking:
    """Watches a hand, and tells which objects have stayed in it.

    Args:
        where: returns where the hand is, shape (3,) [m].
        held: returns how each object lies in it.
    """

    def __init__(self, said: ShakeConfig, where: Callable[[], Array], held: Callable[[], Mapping[str, Lay]]):
        self._said, self._where, self._held = said, where, held
        self.due = -np.inf
        self._turned, self._furthest = list[_Seen](), list[tuple[float, float]]()
        self._strokes, self._needed = np.zeros(3, dtype=int), int(2 * said.frequency * said.seconds) - 1
        self._last = self._looked = self._end = -np.inf
        self._stayed: dict[str, Lay] = {}
        """What has stayed in the hand since the shake began, as it lay then."""

    @property
    def count(self) -> int:
        """How many objects were held through the last shake, and still are as they were; 0 before its end."""
        return len(self._stayed) if (self._strokes >= self._needed).all() else 0

    def look(self, time: float) -> None:
        """Look at where things are at a time [s]; from `due` on."""
        self._looked, self.due, here = time, time + 1 / (LOOKS * self._said.frequency), self._where().tolist()
        if not self._turned:
            self._turned = [_Seen(place, time, self._held()) for place in here]
            self._furthest = [(place, time) for place in here]
        for axis, (place, begun, (end, at)) in enumerate(zip(here, self._turned, self._furthest, strict=True)):
            way = place - end
            if way * (end - begun.place) >= 0:
                self._furthest[axis] = place, time
            elif abs(way) > BACK * self._said.amplitude:
                turned = _Seen(end, at, self._held())
                self._turn(axis, begun, turned)
                self._turned[axis], self._furthest[axis] = turned, (place, time)
        if self._stayed:
            stay, now = self._stayed.items(), self._held()
            self._stayed = {name: before for name, before in stay if name in now and self._as_before(before, now[name])}

    def _turn(self, axis: int, begun: _Seen, end: _Seen) -> None:
        length = abs(end.place - begun.place) / (2 * self._said.amplitude)
        if not SHORT <= length <= 1 / SHORT or end.time - begun.time > SLOW / (2 * self._said.frequency):
            return
        started = (self._strokes > 0) & (self._strokes < self._needed)
        stray = begun.time != self._end and started.any()  # what came before was an arm's overshoot
        if stray or self._looked - self._last > PAUSE:
            self._strokes[:] = 0
            self._stayed = dict(begun.held)
        self._last, self._end = self._looked, end.time
        self._strokes[axis] += 1

    def _as_before(self, before: Lay, now: Lay) -> bool:
        turn = 2 * acos(min(abs(sum(map(mul, before[1], now[1]))), 1.0))
        return dist(before[0], now[0]) <= self._said.shift and turn <= self._said.turn
