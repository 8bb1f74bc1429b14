"""Values to begin with that follow from the project: joint states of its robot, ways through its named states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from grip_gui.wire.setup import Template

from .kinds import JOINT_STATES, Kind
from .options import cameras_in, names_in
from .robot_facts import project_robot_facts

_WAY = ("home", "above")
"""What a way goes through in a project that has named no joint state yet: the page says so."""


def templates_of(kind: Kind, data: object, folder: Path) -> list[Template]:
    """Return what can be put into a file of a kind.

    Args:
        kind: of the file.
        data: what it says now; anything where it is no YAML.
        folder: of the project.
    """
    match kind.name:
        case "joint_states":
            return _joint_states(project_robot_facts(folder)) or list(kind.templates)
        case "trajectories":
            return [_trajectory(names_in(folder / JOINT_STATES))]
        case "project":
            return [*kind.templates, *_controllers(data), *_cameras(data)]
    return list(kind.templates)


def _joint_states(known: Mapping[str, Any]) -> list[Template]:
    """Return one of each group of joints: where its first named state is, so that it is within the limits."""
    found = []
    for group, joints in known.get("groups", {}).items():
        first: Mapping[str, float] = next(iter(known.get("states", {}).get(group, {}).values()), {})
        value = {joint: first.get(joint, 0.0) for joint in joints}
        found.append(Template(title=f"a joint state of {group}", key=["home"], value=value))
    return found


def _trajectory(states: Sequence[str]) -> Template:
    way = [{"name": name, "interpolate_time": 2.0, "pause_time": 0.0} for name in (states[:2] or _WAY)]
    return Template(title="a way through joint states", key=["approach"], value=way)


def _controllers(data: object) -> list[Template]:
    """Return a controller of each arm and hand that the file names."""
    file = data if isinstance(data, Mapping) else {}
    parts = [name for key in ("arms", "hands") if isinstance(file.get(key), Mapping) for name in file[key]]
    value = {name: {"trajectory": f"/{name}_controller/follow_joint_trajectory"} for name in map(str, parts)}
    # Into what is said of the real robot already, which stays.
    return [Template(title="controllers of the real robot", key=["ros", "controllers"], value=value)] if value else []


def _cameras(data: object) -> list[Template]:
    """Return the topics of each camera that the file names, as drivers of RGB-D cameras publish them."""
    value = {
        name: {
            "image": f"/{name}/color/image_raw",
            "depth": f"/{name}/aligned_depth_to_color/image_raw",
            "info": f"/{name}/color/camera_info",
        }
        for name in cameras_in(data if isinstance(data, Mapping) else {})
    }
    return [Template(title="cameras of the real robot", key=["ros", "cameras"], value=value)] if value else []
