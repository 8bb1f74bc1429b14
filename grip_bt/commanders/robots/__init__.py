"""Ready-made robots, built on this machine from models that installed packages carry.

A new robot is a file `ready/NAME.yaml`, which holds what `robot:` in a project file may hold. Three are functions: they
are older.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path
from types import MappingProxyType

from grip_bt.base.errors import InvalidRobotError, MissingPartError, UnknownNameError

from .description import Drive, EndEffector, GraspFrame, Mimic, RobotDescription
from .panda import panda_allegro
from .universal import ur5_allegro, ur10_allegro

READY = Path(__file__).parent / "ready"

EXTRAS: Mapping[str, str] = MappingProxyType(
    {"airo_models": "grippers", "gym_xarm": "grippers", "robopianist": "shadow", "example-robot-data": "motion"}
)
"""Package with models of ready-made robots -> our extra that brings it."""


def _from_file(name: str) -> RobotDescription:
    from ..description.load import load_robot

    try:
        return load_robot(str(READY / f"{name}.yaml"))
    except (InvalidRobotError, MissingPartError) as error:
        for package, extra in EXTRAS.items():  # the file is ours and right: what lacks is what it speaks of
            if f"package {package!r}" in str(error):
                what = f"the model of the robot {name!r}, in the package {package!r},"
                raise MissingPartError(what, f"pip install 'grip-bt[{extra}]'") from None
        raise


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
