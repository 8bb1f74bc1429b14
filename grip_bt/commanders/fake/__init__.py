"""Fakes of every port: at once, deterministic, with scripted failures, for tests and `grip run --robot fake`.

A script has one entry per request: an `ExpectedError` to fail with, or None to do as asked.
"""

from .gantry import FakeArm
from .hand import FakeHand
from .joints import FakeExecutor, Script
from .sources import FakeCamera, FakeComponent, FakeRos, FakeSensor

__all__ = [
    "FakeArm",
    "FakeCamera",
    "FakeComponent",
    "FakeExecutor",
    "FakeHand",
    "FakeRos",
    "FakeSensor",
    "Script",
]
