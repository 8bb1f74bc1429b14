"""What a project's robot has: groups, named states, links, frames; and the planners and solvers that there are."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import fromstring

from pydantic import ValidationError

from grip_bt.base.errors import GripError, InvalidRobotError
from grip_bt.base.interpreter import python_command
from grip_bt.base.yaml.tree import parse, to_data
from grip_bt.commanders.description.config import RobotConfig
from grip_bt.commanders.description.files import FileCache, Stamps
from grip_bt.commanders.description.load import load_robot
from grip_bt.commanders.description.packages import ROBOTS
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
    return _known.get(_key(robot, folder), lambda: _read(robot, folder))


def read_from(robot: object, folder: Path) -> Stamps:
    """Return the files that a robot was read from, as they were."""
    robot_facts(robot, folder)
    return _known.stamps(_key(robot, folder))


def _key(robot: object, folder: Path) -> tuple[str, str]:
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
    found: dict[str, Any] = {
        "robots": list(ROBOTS),
        "planners": sorted([*PLANNERS, MOVE_GROUP]),
        "kinematics": list(SOLVERS),
    }
    if not robot or not isinstance(robot, str | Mapping):  # a project that begins names none, so nothing is wrong
        return found
    try:
        description = load_robot(RobotConfig.model_validate(robot) if isinstance(robot, Mapping) else robot, folder)
    except InvalidRobotError as error:
        return found | {"error": str(error)}
    except (GripError, ValidationError):  # said of the text already
        return found
    found["groups"] = {group: list(joints) for group, joints in description.groups.items()}
    found["states"] = {
        group: {name: dict(zip(state.names, map(float, state.position), strict=True)) for name, state in states.items()}
        for group, states in description.named_states.items()
    }
    links = sorted({link.attrib["name"] for link in fromstring(description.urdf).iter("link") if "name" in link.attrib})
    return found | {"links": links, "frames": ["world", *links]}


PATIENCE = 60.0
"""How long the process may take [s]."""


def geometry(robot: object, hands: Mapping[str, str], folder: Path) -> dict[str, Any]:
    """Return what a robot looks like: `links`, `joints`, `meshes`, `rest`, `grasp`; else `error`.

    Args:
        robot: what a project says of it.
        hands: hand -> its arm's group, to tell where what it holds is.
        folder: that relative paths begin in.
    """
    if not robot:
        return {"error": "grip.yaml names no robot"}
    question = {"robot": robot, "hands": dict(hands), "folder": str(folder)}
    return _asked(json.dumps(question, sort_keys=True, default=str), read_from(robot, folder))


@lru_cache(maxsize=4)
def _asked(question: str, stamps: Stamps) -> dict[str, Any]:
    command = python_command("-m", "grip_gui.setup.robot_drawing")
    try:
        done = subprocess.run(command, input=question, capture_output=True, text=True, timeout=PATIENCE, check=False)
        return dict(json.loads(done.stdout.splitlines()[-1]))
    except (OSError, subprocess.TimeoutExpired, ValueError, IndexError) as error:
        return {"error": f"the robot can't be drawn: {error}"}
