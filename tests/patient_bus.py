"""Connections to ROS for tests: their clients wait as long as a slow machine may need for what surely comes."""

from __future__ import annotations

from collections.abc import Sequence

from patience import PATIENCE

from grip_bt.ros.client.bus import Bus
from grip_bt.ros.controllers import JointStates


class PatientBus(Bus):
    """A bus whose clients are patient where nothing else is said."""

    timeout = wait = PATIENCE


def joints_of(bus: Bus, names: Sequence[str], stale: float = PATIENCE) -> JointStates:
    """Return what is measured of joints, when all are known. By default they stay so, however long nothing comes."""
    states = JointStates(bus, stale=stale)
    states.wait_for(names, PATIENCE)
    return states
