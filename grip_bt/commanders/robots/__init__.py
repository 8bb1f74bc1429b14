"""Ready-made robots, built on this machine from models that installed packages carry.

A new robot is a file `ready/NAME.yaml`, which holds what `robot:` in a project file may hold. Three are functions: they
are older.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path
from types import MappingProxyType

from grip_bt.errors import UnknownNameError

from .description import Drive, EndEffector, GraspFrame, Mimic, RobotDescription
from .panda import panda_allegro
from .universal import ur5_allegro, ur10_allegro

READY = Path(__file__).parent / "ready"


def _from_file(name: str) -> RobotDescription:
    from ..description.load import load_robot

    return load_robot(str(READY / f"{name}.yaml"))


ROBOTS: Mapping[str, Callable[[], RobotDescription]] = MappingProxyType(
    {"panda_allegro": panda_allegro, "ur5_allegro": ur5_allegro, "ur10_allegro": ur10_allegro}
    | {file.stem: partial(_from_file, file.stem) for file in sorted(READY.glob("*.yaml"))}
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


__all__ = ["ROBOTS", "Drive", "EndEffector", "GraspFrame", "Mimic", "RobotDescription", "build_robot"]
