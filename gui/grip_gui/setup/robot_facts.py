"""What a project's robot has: groups, named states, links, frames; the planners and solvers that there are."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import fromstring

from pydantic import ValidationError

from grip_bt.base.errors import GripError, InvalidRobotError
from grip_bt.base.yaml.tree import parse, to_data
from grip_bt.commanders.description.config import RobotConfig
from grip_bt.commanders.description.file_cache import FileCache
from grip_bt.commanders.description.load import load_robot
from grip_bt.commanders.description.packages import ROBOTS
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.settings import PLANNERS, SOLVERS
from grip_bt.task.catalog.ros_config import MOVE_GROUP

_known: FileCache[tuple[str, str], dict[str, Any]] = FileCache()


def robot_facts(robot: object, folder: Path) -> dict[str, Any]:
    """Return what is known about a robot, and about planning; what can't be found out is left out.

    It is read again when one of the files that it was read from has changed.

    Args:
        robot: what a project says of it: a ready-made robot's name, a path, or a description; else it is no robot.
        folder: that relative paths begin in.

    Returns:
        `robots`, `planners`, `kinematics`: names; `groups`: group -> joints; `states`: group -> name -> joint ->
        position [rad or m]; `links` and `frames`: names; `error`: what is wrong with its files.
    """
    return _known.get(key_of(robot, folder), lambda: _read(robot, folder))


def key_of(robot: object, folder: Path) -> tuple[str, str]:
    """Return what tells one robot from another one."""
    return json.dumps(robot, sort_keys=True, default=str), str(folder)


def project_robot_facts(folder: Path) -> dict[str, Any]:
    """Return what is known about the robot of a project's `grip.yaml`, as it is saved; see `robot_facts`."""
    data = data_in(folder / "grip.yaml")
    return robot_facts(data.get("robot") if isinstance(data, Mapping) else None, folder)


def data_in(file: Path) -> Any:
    """Return a YAML file's data; None of one that can't be read, whose faults are told where it is open."""
    try:
        return to_data(parse(file.read_text(encoding="utf-8")))
    except (OSError, ValueError, GripError):
        return None


def is_path(robot: str, folder: Path) -> bool:
    """Return whether a text means a file or a folder, also one that isn't there, rather than a ready-made robot."""
    return bool(robot) and ("/" in robot or "." in robot or (folder / robot).exists())


def _read(robot: object, folder: Path) -> dict[str, Any]:
    planners = sorted([*PLANNERS, MOVE_GROUP])
    found: dict[str, Any] = {"robots": list(ROBOTS), "planners": planners, "kinematics": list(SOLVERS)}
    if not robot or not isinstance(robot, str | Mapping):  # a project that begins names none, so nothing is wrong
        return found
    try:
        description = load_robot(RobotConfig.model_validate(robot) if isinstance(robot, Mapping) else robot, folder)
    except InvalidRobotError as error:
        return found | {"error": str(error)}
    except (GripError, ValidationError):  # said of the text already
        return found
    found["groups"] = {group: list(joints) for group, joints in description.groups.items()}
    found["states"] = states_of(description)
    links = sorted({link.attrib["name"] for link in fromstring(description.urdf).iter("link") if "name" in link.attrib})
    return found | {"links": links, "frames": ["world", *links]}


def states_of(description: RobotDescription) -> dict[str, dict[str, dict[str, float]]]:
    """Return group -> name -> joint -> position [rad or m] of its named states."""
    return {
        group: {name: dict(state.as_mapping()) for name, state in states.items()}
        for group, states in description.named_states.items()
    }
