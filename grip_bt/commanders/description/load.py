"""Robots from configurations: the files are read, checked as a whole, and made into a `RobotDescription`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from grip_bt.base.errors import DocumentError, InvalidRobotError, UnknownNameError

from ..moveit_package import MoveItPackage
from ..robots.description import RobotDescription
from .config import RobotConfig
from .findings import Finding, errors, finding_of
from .joining import Placed, in_one_world, namespaced, on_arm
from .single import Loaded, load_single
from .sources import config_of, is_ready_made


@dataclass(frozen=True)
class Inspected:
    """A robot with everything that was found about it.

    Attributes:
        findings: errors and warnings of all its files.
        description: the robot; None where a finding is an error.
        packages: the MoveIt configuration packages that it was read from.
    """

    findings: tuple[Finding, ...]
    description: RobotDescription | None = None
    packages: tuple[MoveItPackage, ...] = ()


def load_robot(source: str | RobotConfig, folder: Path | None = None) -> RobotDescription:
    """Return a robot.

    Args:
        source: a ready-made robot's name, a path of a file or folder (see `sources.config_of`), or a configuration.
        folder: that relative paths begin in; the current one when None.

    Raises:
        InvalidRobotError: its files are wrong; it holds everything that was found.
        UnknownNameError: there is neither such a robot nor such a file.
        MissingPartError: the data of a ready-made robot isn't installed.
    """
    inspected = inspect_robot(source, folder)
    if inspected.description is None:
        name = source if isinstance(source, str) else source.name or "robot"
        raise InvalidRobotError(name, errors(inspected.findings))
    return inspected.description


def inspect_robot(source: str | RobotConfig, folder: Path | None = None) -> Inspected:
    """Return a robot with all that is wrong with its files; arguments as for `load_robot`.

    Raises:
        UnknownNameError: there is neither such a robot nor such a file.
        MissingPartError: the data of a ready-made robot isn't installed.
    """
    folder, named = (folder or Path()).resolve(), ""
    if isinstance(source, str):
        if is_ready_made(source):
            from ..robots import build_robot

            return Inspected((), build_robot(source))
        named = Path(source).stem
        try:
            source, folder = config_of(source, folder)
        except DocumentError as error:
            return Inspected((finding_of(error),))
    try:
        return _renamed(_inspected(source, folder), source, named)
    except (DocumentError, UnknownNameError) as error:
        return Inspected((finding_of(error),))
    except RecursionError:
        return Inspected((Finding("error", "cycle", "the robot is, in the end, a part of itself"),))


def _inspected(config: RobotConfig, folder: Path) -> Inspected:
    if config.ready is not None:
        return _ready_made(config.ready, config, folder)
    if config.robots:
        return _several(config, folder)
    if config.arm is not None and config.hand is not None and config.mount is not None:
        arm, hand = inspect_robot(config.arm, folder), inspect_robot(config.hand, folder)
        if arm.description is None or hand.description is None:
            return _together((arm, hand), None)
        name = config.name or f"{arm.description.name}_{hand.description.name}"
        return _together((arm, hand), on_arm(arm.description, hand.description, config.mount, name, config))
    loaded: Loaded = load_single(config, folder)
    return Inspected(loaded.findings, loaded.description, loaded.packages)


def _ready_made(name: str, config: RobotConfig, folder: Path) -> Inspected:
    """Return a ready-made robot, one with sizes of its own where arguments are given.

    Raises:
        DocumentError: this robot takes none.
    """
    if not config.arguments:
        return inspect_robot(name, folder)
    from ..robots import READY, ROBOTS

    file = READY / f"{name}.yaml"
    own, place = config_of(str(file), folder) if name in ROBOTS and file.is_file() else (None, folder)
    if own is None or own.xacro is None:
        raise DocumentError(f"the ready-made robot {name!r} takes no arguments", str(folder))
    given = own.model_copy(update={"arguments": {**own.arguments, **config.arguments}})
    return _renamed(_inspected(given, place), given, name)


def _several(config: RobotConfig, folder: Path) -> Inspected:
    parts = {name: inspect_robot(placed.robot, folder) for name, placed in config.robots.items()}
    placed = {
        name: Placed(part.description, config.robots[name].xyz, config.robots[name].rpy)
        for name, part in parts.items()
        if part.description is not None
    }
    whole = len(placed) == len(parts)
    return _together(
        parts.values(), in_one_world(placed, config.name or "_and_".join(parts), config) if whole else None
    )


def _together(parts: Iterable[Inspected], description: RobotDescription | None) -> Inspected:
    parts = tuple(parts)
    return Inspected(
        tuple(finding for part in parts for finding in part.findings),
        description,
        tuple(package for part in parts for package in part.packages),
    )


def _renamed(inspected: Inspected, config: RobotConfig, file: str) -> Inspected:
    description = inspected.description
    if description is None:
        return inspected
    if config.namespace is not None:
        description = namespaced(description, f"{config.namespace}_")
    if config.name or file:
        description = replace(description, name=config.name or file)
    return replace(inspected, description=description)
