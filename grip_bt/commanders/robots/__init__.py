"""Ready-made robots, built on this machine from the models of the example-robot-data wheel.

A new robot is one more function that returns a `RobotDescription`, and one more line in `ROBOTS`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from types import MappingProxyType

from grip_bt.errors import UnknownNameError

from .description import Drive, GraspFrame, RobotDescription
from .panda import panda_allegro
from .universal import ur5_allegro, ur10_allegro

ROBOTS: Mapping[str, Callable[[], RobotDescription]] = MappingProxyType(
    {"panda_allegro": panda_allegro, "ur5_allegro": ur5_allegro, "ur10_allegro": ur10_allegro}
)


@cache
def build_robot(name: str) -> RobotDescription:
    """Return a ready-made robot.

    Raises:
        UnknownNameError: there is no such robot.
        MissingPartError: its model files aren't installed.
    """
    if name not in ROBOTS:
        raise UnknownNameError("robot", name, ROBOTS)
    return ROBOTS[name]()


__all__ = ["ROBOTS", "Drive", "GraspFrame", "RobotDescription", "build_robot"]
