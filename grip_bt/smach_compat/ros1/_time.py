"""rospy's Time and Duration: ROS 2's own messages, where they are there, with what those of ROS 1 have.

So a stamp that legacy code makes fits into a message, and one that comes out of a message can be reckoned with.
"""

from __future__ import annotations

import functools
import importlib
from typing import Any

from grip_bt.smach_compat.smach_ros._connection import ros

_SECOND = 10**9


class _Whole:
    """Seconds and nanoseconds as in the messages: the latter are never negative."""

    def __init__(self, *, sec: int = 0, nanosec: int = 0):
        self.sec, self.nanosec = sec, nanosec

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self.to_nsec() == other.to_nsec()  # type: ignore[attr-defined]

    def __repr__(self) -> str:
        return f"{type(self).__name__}(sec={self.sec}, nanosec={self.nanosec})"


class _Reckoned:
    """What both have."""

    sec: int
    nanosec: int

    def to_nsec(self) -> int:
        return self.sec * _SECOND + self.nanosec

    def to_sec(self) -> float:
        return self.to_nsec() / _SECOND

    def is_zero(self) -> bool:
        return self.to_nsec() == 0

    def __lt__(self, other: Any) -> bool:
        if type(self) is not type(other):
            raise TypeError(f"{type(self).__name__} and {type(other).__name__} can't be compared")
        return bool(self.to_nsec() < other.to_nsec())

    def __hash__(self) -> int:
        return hash(self.to_nsec())


class _TimeOfRos1(_Reckoned):
    to_time = _Reckoned.to_sec

    def __add__(self, duration: Any) -> Any:
        return Time(0, self.to_nsec() + duration.to_nsec())

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        return (Duration if isinstance(other, Time) else Time)(0, self.to_nsec() - other.to_nsec())


class _DurationOfRos1(_Reckoned):
    def __add__(self, other: Any) -> Any:
        return type(other)(0, self.to_nsec() + other.to_nsec())

    def __sub__(self, other: Any) -> Any:
        return Duration(0, self.to_nsec() - other.to_nsec())

    def __mul__(self, factor: float) -> Any:
        return Duration(0, round(self.to_nsec() * factor))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        return self.to_nsec() / other.to_nsec() if isinstance(other, Duration) else self * (1 / other)

    def __neg__(self) -> Any:
        return self * -1

    def __abs__(self) -> Any:
        return Duration(0, abs(self.to_nsec()))


def _class(name: str, more: type) -> Any:
    try:
        made: Any = getattr(importlib.import_module("builtin_interfaces.msg"), name)
    except ImportError:
        made = type(name, (_Whole,), {})
    begun = made.__init__

    @functools.wraps(begun)
    def init(self: Any, secs: float = 0, nsecs: int = 0, **fields: Any) -> None:
        sec, nanosec = divmod(round(secs * _SECOND) + nsecs, _SECOND)
        begun(self, **(fields or {"sec": sec, "nanosec": nanosec}))

    for each in (_Reckoned, more):
        for key, value in vars(each).items():
            if key not in ("__dict__", "__weakref__", "__module__", "__doc__", "__annotations__"):
                setattr(made, key, value)
    made.__init__ = init
    made.secs, made.nsecs = property(lambda self: self.sec), property(lambda self: self.nanosec)
    made.from_sec = made.from_seconds = staticmethod(lambda seconds: made(seconds))
    return functools.total_ordering(made)


Time = _class("Time", _TimeOfRos1)
Duration = _class("Duration", _DurationOfRos1)


def now() -> Any:
    """Return ROS's time."""
    return Time(ros().now())


Time.now = staticmethod(now)
