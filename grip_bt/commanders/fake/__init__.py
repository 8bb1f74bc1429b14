"""Fakes of every port: deterministic, without threads, with scripted failures, for tests and `grip run --robot fake`.

Their time is a `Schedule`. A script has one entry per request: an `ExpectedError` to fail with, or None to do as asked.
"""

from .gantry import FakeArm
from .hand import FakeHand
from .joints import AtOnce, FakeExecutor, OnClock, Schedule
from .sources import FakeCamera, FakeComponent, FakeRos, FakeSensor

__all__ = [
    "AtOnce",
    "FakeArm",
    "FakeCamera",
    "FakeComponent",
    "FakeExecutor",
    "FakeHand",
    "FakeRos",
    "FakeSensor",
    "OnClock",
    "Schedule",
]
