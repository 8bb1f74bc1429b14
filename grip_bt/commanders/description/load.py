"""Robots by one word or from configurations: files are read, checked as a whole, and made into a description.

Ready-made robots are built on this machine from models that installed packages carry.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

from grip_bt.base.errors import DocumentError, InvalidRobotError, MissingPartError, UnknownNameError
from grip_bt.base.yaml.models import check_model, document_error, read_model
from grip_bt.base.yaml.tree import YamlMapping, parse, read_file, to_data
from grip_bt.commanders.description.packages import ROBOTS

from .compose import in_one_world, namespaced, on_arm
from .config import RobotConfig
from .file_cache import FileCache, note
from .files import errors, finding_of, robot_issue
from .from_files import Inspected, load_single
from .launched import is_launch_file, robot_of_launch
from .robot import RobotDescription

PROJECT = "grip.yaml"


@cache
def build_robot(name: str) -> RobotDescription:
    """Return a ready-made robot.

    Raises:
        UnknownNameError: there is no such robot.
        MissingPartError: its model files aren't installed.
    """
    if name not in ROBOTS:
        raise UnknownNameError("robot", name, ROBOTS)
    try:
        inspected = inspect_robot(str(ROBOTS[name]))
        said = " ".join(finding.message for finding in inspected.findings)
    except MissingPartError as error:
        inspected, said = Inspected(()), str(error)
    if (package := "package 'example-robot-data'") in said:  # the file is ours and right: what it speaks of lacks
        raise MissingPartError(f"the model of the robot {name!r}, in the {package},", "pip install 'grip-bt[robots]'")
    if inspected.description is None:
        raise InvalidRobotError(name, errors(inspected.findings))
    return inspected.description


def load_robot(source: str | RobotConfig, folder: Path | None = None) -> RobotDescription:
    """Return a robot.

    Args:
        source: a ready-made robot's name, a path of a file or folder (see `config_of`), or a configuration.
        folder: that relative paths begin in; the current one when None.

    Raises:
        InvalidRobotError: its files are wrong; it holds everything that was found.
        UnknownNameError: there is neither such a robot nor such a file.
        MissingPartError: the data of a ready-made robot isn't installed.
    """
    if isinstance(source, str) and source in ROBOTS:
        return build_robot(source)
    key = source if isinstance(source, str) else source.model_dump_json(), (folder or Path()).resolve()
    inspected = _inspected_files.get(key, lambda: inspect_robot(source, folder))
    if inspected.description is None:
        name = source if isinstance(source, str) else source.name or "robot"
        raise InvalidRobotError(name, errors(inspected.findings))
    return inspected.description


_inspected_files: FileCache[tuple[str, Path], Inspected] = FileCache()


def inspect_robot(source: str | RobotConfig, folder: Path | None = None) -> Inspected:
    """Return a robot with all that is wrong with its files; arguments as for `load_robot`.

    Raises:
        UnknownNameError: there is neither such a robot nor such a file.
        MissingPartError: the data of a ready-made robot isn't installed.
    """
    folder, named = (folder or Path()).resolve(), ""
    if isinstance(source, str):
        if source in ROBOTS:
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
        return Inspected((robot_issue("error", "cycle", "the robot contains itself"),))


def _inspected(config: RobotConfig, folder: Path) -> Inspected:
    if config.ready is not None:
        return _ready_made(config.ready, config, folder)
    if not config.robots and config.mount is None:
        return load_single(config, folder)
    written: dict[str, str | RobotConfig | None] = {name: placed.robot for name, placed in config.robots.items()}
    written = written or {"arm": config.arm, "hand": config.hand}
    parts = {name: inspect_robot(each, folder) for name, each in written.items() if each is not None}
    robots = {name: part.description for name, part in parts.items() if part.description is not None}
    whole = None
    if len(robots) == len(parts) and config.mount is None:
        whole = in_one_world(robots, config.name or "_and_".join(parts), config)
    elif len(robots) == len(parts):
        name = config.name or f"{robots['arm'].name}_{robots['hand'].name}"
        assert config.mount is not None
        whole = on_arm(robots["arm"], robots["hand"], config.mount, name, config)
    return Inspected(
        tuple(finding for part in parts.values() for finding in part.findings),
        whole,
        tuple(package for part in parts.values() for package in part.packages),
    )


def _ready_made(name: str, config: RobotConfig, folder: Path) -> Inspected:
    """Return a ready-made robot, with whatever else is said of it beside `ready`."""
    said = {key: value for key in _ADDED if (value := getattr(config, key))}
    if not said or name not in ROBOTS:
        return inspect_robot(name, folder)
    own, place = config_of(str(ROBOTS[name]), folder)
    if config.arguments and own.xacro is None:
        raise DocumentError(f"the ready-made robot {name!r} takes no arguments", str(folder))
    merged = {key: {**getattr(own, key), **value} for key, value in said.items()}
    if config.states:
        merged["states"] = {**own.states, **{g: {**own.states.get(g, {}), **at} for g, at in config.states.items()}}
    given = own.model_copy(update=merged)
    return _renamed(_inspected(given, place), given, name)


_ADDED = ("arguments", "groups", "states", "end_effectors", "grasp_frames", "fingers", "drives", "accelerations")
"""What may be said of a ready-made robot: what is new, or in place of its own."""


def _renamed(inspected: Inspected, config: RobotConfig, file: str) -> Inspected:
    description = inspected.description
    if description is None:
        return inspected
    if config.namespace is not None:
        description = namespaced(description, f"{config.namespace}_")
    if config.name or file:
        description = replace(description, name=config.name or file)
    return replace(inspected, description=description)


def config_of(word: str, folder: Path) -> tuple[RobotConfig, Path]:
    """Return the configuration that a path stands for, and the folder that its relative paths begin in.

    `*.urdf`, `*.xacro` and `*.xml` (URDF or MJCF) are robots by themselves, a launch file names one, `*.yaml` holds a
    configuration; a project's and a world's file under `robot:`. A folder is a project, or a MoveIt configuration
    package.

    Raises:
        UnknownNameError: there is neither such a file nor such a ready-made robot.
        DocumentError: the file is of another kind, or its configuration is wrong.
    """
    path = (folder / Path(word).expanduser()).resolve()
    if path.is_dir() and not (path / PROJECT).is_file():
        return RobotConfig(moveit=str(path)), path.parent
    if path.is_dir():
        path = path / PROJECT
    note(path)
    if not path.is_file():
        if "/" in word or path.suffix:
            raise DocumentError("there is no such file", str(path))
        raise UnknownNameError("robot", word, ROBOTS, where="not a file, and not a ready-made robot")
    if is_launch_file(path):
        return robot_of_launch(path), path.parent
    if path.suffix in (".urdf", ".xacro", ".xml"):
        return RobotConfig(**{"xacro" if path.suffix == ".xacro" else "urdf": str(path)}), path.parent
    if path.suffix in (".yaml", ".yml"):
        return _of_yaml(path), path.parent
    raise DocumentError(
        "a robot is a .urdf, .xacro, .xml (URDF), .yaml or launch file, or a MoveIt package's folder", str(path)
    )


def _of_yaml(path: Path) -> RobotConfig:
    tree = parse(read_file(path), str(path))
    if not isinstance(tree, YamlMapping) or (path.name != PROJECT and "grip" not in tree.entries):
        return read_model(path, RobotConfig)
    entry = tree.entries.get("robot")
    if entry is None:
        raise DocumentError("the file names no `robot:`", str(path))
    if isinstance(word := to_data(entry.value), str):
        return RobotConfig(ready=word)
    config, faults = check_model(entry.value, RobotConfig)
    if config is None:
        raise document_error(faults, str(path))
    return config
