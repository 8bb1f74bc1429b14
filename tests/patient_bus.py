"""Connections to ROS for tests: their clients wait as long as a slow machine may need for what surely comes."""

from __future__ import annotations

from collections.abc import Sequence

from patience import PATIENCE

from grip_bt.ros.bus import Bus
from grip_bt.ros.controllers import JointStates


class PatientBus(Bus):
    """A bus whose clients are patient where nothing else is said."""

    def service(self, interface, name, timeout=PATIENCE, wait=PATIENCE):
        return super().service(interface, name, timeout, wait)

    def action(self, interface, name, timeout=PATIENCE, wait=PATIENCE):
        return super().action(interface, name, timeout, wait)

    def reader(self, interface, name, timeout=PATIENCE):
        return super().reader(interface, name, timeout)

    def writer(self, interface, name, timeout=PATIENCE):
        return super().writer(interface, name, timeout)


def joints_of(bus: Bus, names: Sequence[str], stale: float = PATIENCE) -> JointStates:
    """Return what is measured of joints, when all are known. By default they stay so, however long nothing comes."""
    states = JointStates(bus, stale=stale)
    states.wait_for(names, PATIENCE)
    return states
