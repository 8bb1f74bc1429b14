"""Fakes of every port: at once and deterministic, for tests and `grip run --robot fake`."""

from .gantry import FakeArm
from .joints import FakeExecutor, FakeHand
from .sources import FakeCamera, FakeComponent, FakeRos, FakeSensor

__all__ = [
    "FakeArm",
    "FakeCamera",
    "FakeComponent",
    "FakeExecutor",
    "FakeHand",
    "FakeRos",
    "FakeSensor",
]
