"""Values to begin with that follow from the project: joint states of its robot, ways through its named states."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from grip_gui.wire.setup import Template

from .kinds import JOINT_STATES, Kind
from .options import cameras_in, keys_in, names_in
from .robot_facts import project_robot_facts

_WAY = ("home", "above")
"""What a way goes through in a project that has named no joint state yet: the page says so."""


def templates_of(kind: Kind, data: object, folder: Path) -> list[Template]:
    """Return what can be put into a project's file of a kind, which says `data` now (anything where it is no YAML)."""
    match kind.name:
        case "joint_states":
            return _joint_states(project_robot_facts(folder)) or list(kind.templates)
        case "trajectories":
            way = [
                {"name": name, "interpolate_time": 2.0, "pause_time": 0.0}
                for name in (names_in(folder / JOINT_STATES)[:2] or _WAY)
            ]
            return [Template(title="a way through joint states", key=["approach"], value=way)]
        case "project" if isinstance(data, Mapping):
            return [*kind.templates, *_of_real_robot(data)]
    return list(kind.templates)


def _joint_states(known: Mapping[str, Any]) -> list[Template]:
    """Return one of each group of joints: where its first named state is, so that it is within the limits."""
    found = []
    for group, joints in known.get("groups", {}).items():
        first: Mapping[str, float] = next(iter(known.get("states", {}).get(group, {}).values()), {})
        value = {joint: first.get(joint, 0.0) for joint in joints}
        found.append(Template(title=f"a joint state of {group}", key=["home"], value=value))
    return found


def _of_real_robot(data: Mapping[str, object]) -> Iterator[Template]:
    """Yield a controller of each arm and hand that the file names, and topics of each camera, as RGB-D drivers do.

    They are put into what is said of the real robot already, which stays.
    """
    parts = [*keys_in(data, "arms"), *keys_in(data, "hands")]
    if controllers := {name: {"trajectory": f"/{name}_controller/follow_joint_trajectory"} for name in parts}:
        yield Template(title="controllers of the real robot", key=["ros", "controllers"], value=controllers)
    topics = {
        "image": "color/image_raw",
        "depth": "aligned_depth_to_color/image_raw",
        "info": "color/camera_info",
    }
    if cameras := {name: {key: f"/{name}/{topic}" for key, topic in topics.items()} for name in cameras_in(data)}:
        yield Template(title="cameras of the real robot", key=["ros", "cameras"], value=cameras)
