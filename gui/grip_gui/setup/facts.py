"""What may stand in a project's fields: robots, planners, solvers, groups, named states. Asked in a process of its own.

Robot descriptions load native code; a broken one must not take the editor down.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import fromstring

from grip_bt.base.interpreter import python_command

PATIENCE = 60.0
"""How long the process may take [s]."""
FILES, LONGEST_PATH = 500, 1000
"""Most files of a folder that are looked at for changes, and the longest text that is taken for a path."""


def facts(robot: object, folder: Path) -> dict[str, Any]:
    """Return what is known about a robot, and about planning; what can't be found out is left out.

    Args:
        robot: what a project says of it: a ready-made robot's name, a path, or a description; else it is no robot.
        folder: that relative paths begin in.

    Returns:
        `robots`, `planners`, `kinematics`: names; `groups`: group -> joints; `states`: group -> name -> joint ->
        position [rad or m]; `links` and `frames`: names; `trouble`: what is wrong with its files, where they are.
    """
    if not isinstance(robot, str | Mapping):
        robot = ""
    asked = json.dumps(robot, sort_keys=True, default=str)
    by_name = isinstance(robot, str) and not is_path(robot, folder)
    return _asked(asked, "." if by_name else str(folder), 0.0 if by_name else stamp_of(robot, folder))


def is_path(robot: str, folder: Path) -> bool:
    """Return whether a text means a file or a folder, also one that isn't there, rather than a ready-made robot."""
    return bool(robot) and ("/" in robot or "." in robot or (folder / robot).exists())


@lru_cache(maxsize=16)
def _asked(robot: str, folder: str, stamp: float) -> dict[str, Any]:
    command = python_command("-m", "grip_gui.setup.facts", robot, folder)
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)
        found = json.loads(done.stdout.splitlines()[-1]) if done.returncode == 0 else {}
    except (OSError, subprocess.TimeoutExpired, ValueError, IndexError):
        return {}
    return dict(found)


def stamp_of(robot: object, folder: Path) -> float:
    """Return when the files that a robot names were changed last [s since 1970]; 0 for none."""
    words = robot.values() if isinstance(robot, Mapping) else (robot,)
    latest = 0.0
    for word in words:
        if isinstance(word, Mapping):
            latest = max(latest, stamp_of(word, folder))
        elif isinstance(word, str) and word and len(word) < LONGEST_PATH:
            place = folder / word
            files = [place] if place.is_file() else islice(place.rglob("*"), FILES) if place.is_dir() else []
            latest = max([latest, *(file.stat().st_mtime for file in files if file.is_file())])
    return latest


def _gathered(robot: Any, folder: Path) -> dict[str, Any]:
    from pydantic import ValidationError

    from grip_bt.base.errors import GripError, InvalidRobotError
    from grip_bt.commanders.description.config import RobotConfig
    from grip_bt.commanders.description.load import load_robot
    from grip_bt.commanders.ik import SOLVERS
    from grip_bt.commanders.planning.free import planners
    from grip_bt.commanders.robots import ROBOTS
    from grip_bt.task.catalog.controller_config import MOVE_GROUP

    found: dict[str, Any] = {
        "robots": list(ROBOTS),
        "planners": sorted([*planners(), MOVE_GROUP]),
        "kinematics": list(SOLVERS),
    }
    if not robot:  # a project that begins: nothing can be wrong with a robot that it hasn't named
        return found
    try:
        source = RobotConfig.model_validate(robot) if isinstance(robot, Mapping) else str(robot)
        description = load_robot(source, folder)
    except InvalidRobotError as error:
        return found | {"trouble": str(error)}
    except (GripError, ValidationError):  # said of the text already
        return found
    found["groups"] = {group: list(joints) for group, joints in description.groups.items()}
    found["states"] = {
        group: {name: dict(zip(state.names, map(float, state.position), strict=True)) for name, state in states.items()}
        for group, states in description.named_states.items()
    }
    links = [link.attrib["name"] for link in fromstring(description.urdf).iter("link") if "name" in link.attrib]
    return found | {"links": sorted(set(links)), "frames": ["world", *sorted(set(links))]}


def main() -> int:
    """Print what is known about the robot that the command line names, as one line of JSON."""
    sys.stdout.write("\n" + json.dumps(_gathered(json.loads(sys.argv[1]), Path(sys.argv[2]))) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
