"""Fakes of every port: deterministic, without threads, with scripted failures.

They serve tests and `grip run --robot fake`. Their time is a `Schedule`: at once, or on a clock that the test moves. A
script is a sequence with one entry per request: an `ExpectedError` to fail with, or None to do as asked; after its end
they do as asked.
"""

from .arm import FakeArm
from .camera import FakeCamera
from .component import FakeComponent
from .executor import FakeExecutor
from .hand import FakeHand
from .ros import FakeRos
from .schedule import AtOnce, OnClock, Schedule
from .sensor import FakeSensor

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
