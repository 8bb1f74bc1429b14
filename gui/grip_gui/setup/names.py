"""What the project's files name, for the parameters of a task's leaves: arms, hands, named states, messages, frames."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from grip_bt.app.project.config import ProjectFile
from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import GripError

from .facts import facts
from .kinds import JOINT_STATES, POSES, TRAJECTORIES
from .options import names_in

STORES = ["joint_states", "poses", "robot_poses", "trajectories", "plans", "grasps", "clouds", "images"]
FREE = ["none", "x", "y", "z", "orientation"]
SHAPES = ["box", "cylinder", "sphere"]


def names_of(folder: Path) -> dict[str, list[str]]:
    """Return what may stand in parameters, among other things: `node/parameter`, with `*` for any word, -> names.

    Args:
        folder: of the project; one whose `grip.yaml` can't be read offers what needs no robot.
    """
    messages = [name for path in (POSES, JOINT_STATES, TRAJECTORIES) for name in names_in(folder / path)]
    found = {
        "messages/*/store": STORES,
        "messages/*/name": sorted(set(messages)),
        "arm/*/free": FREE,
        "scene/add_shape/shape": SHAPES,
    }
    try:
        file = find_project(folder).file
    except GripError:  # said where that file is open
        return found
    found |= {"*/*/arm": list(file.arms), "*/*/arms": list(file.arms), "*/*/hand": list(file.hands)}
    if file.robot is None:
        return found
    robot = file.robot if isinstance(file.robot, str) else file.robot.model_dump(mode="json", exclude_defaults=True)
    return found | _of_robot(robot, file, folder)


def _of_robot(robot: object, file: ProjectFile, folder: Path) -> dict[str, list[str]]:
    known: Mapping[str, Any] = facts(robot, folder)
    states: Mapping[str, Iterable[str]] = known.get("states", {})
    frames = list(known.get("frames", ()))
    return {
        "arm/*/state": _united(_states_of(name, file, states) for name in file.arms),
        "hand/*/posture": _united(states.get(hand.group, ()) for hand in file.hands.values()),
        "*/*/frame": frames,
        "ros/lookup_transform/target": frames,
        "ros/lookup_transform/source": frames,
    }


def _states_of(name: str, file: ProjectFile, states: Mapping[str, Iterable[str]]) -> Iterable[str]:
    """Return the named states of an arm; of one that joins others, those that all of them have."""
    arm = file.arms[name]
    if not arm.arms:
        return states.get(arm.group, ())
    parts = [set(states.get(file.arms[each].group, ())) for each in arm.arms if each in file.arms]
    return set.intersection(*parts) | set(states.get(arm.group, ())) if parts else ()


def _united(names: Iterable[Iterable[str]]) -> list[str]:
    return sorted({name for some in names for name in some})
