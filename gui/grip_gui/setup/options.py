"""What may stand in a settings file's fields and in the parameters of leaves, and what a file may begin with."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, get_args

from grip_bt.app.project.folder import find_project
from grip_bt.app.project.parts import project_parts_of
from grip_bt.base.errors import GripError, listing, nearest
from grip_bt.base.message_store import STANDARD
from grip_bt.base.yaml.models import Diagnostic, find
from grip_bt.base.yaml.tree import YamlValue
from grip_bt.task.catalog.port_type import Unit
from grip_bt.task.catalog.ros_config import MESSAGES
from grip_gui.setup.kinds import JOINT_STATES, POSES, TRAJECTORIES, Kind
from grip_gui.setup.robot_facts import data_in, is_path, project_robot_facts, robot_facts
from grip_gui.wire.setup import Template
from grip_sim.worlds import read_world, world_files

FREE = ["none", "x", "y", "z", "orientation"]
SHAPES = ["box", "cylinder", "sphere"]
CLOSED = set(
    "robot world arms/*/planner arms/*/kinematics arms/*/group arms/*/hand hands/*/group ros/controllers/? "
    "ros/cameras/? */*/name".split()
)
"""Where nothing else than the options may stand; at `?`, as a key."""
_PLACES = {
    "planners": "arms/*/planner",
    "kinematics": "arms/*/kinematics",
    "robots": "robot/ready robot/arm robot/hand robot/robots/*/robot",
    "links": "robot/mount/link robot/grasp_frames/*/link robot/end_effectors/*/parent_link",
    "frames": "sensors/*/mount/on",
    "groups": "arms/*/group hands/*/group robot/end_effectors/*/group robot/end_effectors/*/parent_group "
    "robot/grasp_frames/? robot/fingers/? robot/states/?",
}
"""What is known about a robot -> where it may stand."""
_WAY = ("home", "above")  # what a way goes through in a project that has named no joint state yet: the page says so
_OF_ROBOT = {"joint_states": ("joint", "*/?"), "poses": ("frame", "*/reference_frame")}
"""Kind of file -> what the robot has to have, and where it is named."""
_NONE_YET = {
    "arms/*/hand": "name it under `hands` first",
    "ros/controllers/?": "name it under `arms` or `hands` first",
    "ros/cameras/?": "no sensor says `camera`: write `sensors: {NAME: {camera: overhead}}`",
}


def options_of(kind: str, data: object, folder: Path) -> dict[str, list[str]]:
    """Return path of keys, with `*` for any -> what may stand there; `?` for the names of a mapping's own keys."""
    match kind:
        case "project":
            return _project(data if isinstance(data, Mapping) else {}, folder)
        case "component":
            return {
                "meaning/*": ["success", "failure"],
                "ports/*/type": sorted(MESSAGES),
                "ports/*/unit": list(get_args(Unit)),
            }
        case "joint_states":
            return {"*/?": _joints_in(project_robot_facts(folder))}
        case "trajectories":
            return {"*/*/name": _names(data_in(folder / JOINT_STATES))}
        case "poses":
            sensors = _names((data_in(folder / "grip.yaml") or {}).get("sensors"))
            return {"*/reference_frame": [*project_robot_facts(folder).get("frames", ["world"]), *sensors]}
    return {}


def wrong_options(tree: YamlValue, data: object, options: Mapping[str, Sequence[str]]) -> list[Diagnostic]:
    """Return the values that none of the options are."""
    faults = []
    for pattern in CLOSED & options.keys():
        allowed = options[pattern]
        for path, value in _at(data, pattern.split("/"), ()):
            if isinstance(value, str) and value not in allowed:
                line, column = find(tree, path)
                words = "/".join(map(str, path))
                there = f"available: {listing(allowed)}" if allowed else _NONE_YET.get(pattern, "none are defined yet")
                message = f"{words}: there is no {value!r}{nearest(value, allowed)} ({there})"
                faults.append((message, line, column))
    return faults


def doubtful_names(
    kind: str, tree: YamlValue, data: object, options: Mapping[str, Sequence[str]], folder: Path
) -> list[Diagnostic]:
    """Return the names in files of messages that the project's robot doesn't have; something else may have them."""
    if kind not in _OF_ROBOT or not project_robot_facts(folder).get("groups"):
        return []
    what, pattern = _OF_ROBOT[kind]
    return [
        (
            f"{'/'.join(map(str, path))}: the robot has no {what} {name!r}{nearest(name, options[pattern])}",
            *find(tree, path),
        )
        for path, name in _at(data, pattern.split("/"), ())
        if isinstance(name, str) and name not in options[pattern]
    ]


def _project(data: Mapping[str, object], folder: Path) -> dict[str, list[str]]:
    robot = data.get("robot")
    known = robot_facts(robot, folder)
    found = {place: list(known[name]) for name in _PLACES.keys() & known for place in _PLACES[name].split()}
    if not isinstance(robot, str) or not is_path(robot, folder):
        found["robot"] = list(known["robots"])  # where it is a file, its path is as good
    found |= {
        "ros/controllers/?": [*_names(data.get("arms")), *_names(data.get("hands"))],
        "ros/cameras/?": _cameras_in(data),
        "ros/cameras/*/mount/on": list(known.get("frames", ["world"])),
        "arms/*/hand": _names(data.get("hands")),
        "world": list(world_files(folder)),
        "sensors/*/camera": _world_cameras(data.get("world"), folder),
        "sensors/*/topics/*/type": sorted(MESSAGES),
        "sensors/*/topics/*/message": sorted(set(MESSAGES.values())),
    }
    if groups := known.get("groups"):
        found["robot/accelerations/?"] = [*groups, *_joints_in(known)]
    return found


def _joints_in(known: Mapping[str, Any]) -> list[str]:
    return sorted({joint for group in known.get("groups", {}).values() for joint in group})


def _world_cameras(world: object, folder: Path) -> list[str]:
    try:
        return list(read_world(str(world), folder)[0].cameras)
    except GripError:
        return []


def templates_of(kind: Kind, data: object, folder: Path) -> list[Template]:
    """Return what can be put into a project's file of a kind, which says `data` now (anything where it is no YAML)."""
    match kind.name:
        case "joint_states":
            return _joint_states(project_robot_facts(folder)) or list(kind.templates)
        case "trajectories":
            way = [
                {"name": name, "interpolate_time": 2.0, "pause_time": 0.0}
                for name in (_names(data_in(folder / JOINT_STATES))[:2] or _WAY)
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
    """Yield a controller of each arm and hand that the file names, and topics of each camera, as RGB-D drivers do."""
    parts = [*_names(data.get("arms")), *_names(data.get("hands"))]
    if controllers := {name: {"trajectory": f"/{name}_controller/follow_joint_trajectory"} for name in parts}:
        yield Template(title="controllers of the real robot", key=["ros", "controllers"], value=controllers)
    topics = {"image": "color/image_raw", "depth": "aligned_depth_to_color/image_raw", "info": "color/camera_info"}
    if cameras := {name: {key: f"/{name}/{topic}" for key, topic in topics.items()} for name in _cameras_in(data)}:
        yield Template(title="cameras of the real robot", key=["ros", "cameras"], value=cameras)


def _cameras_in(data: Mapping[str, object]) -> list[str]:
    """Return the sensors of a project file's data that say `camera`."""
    return [str(path[1]) for path, _ in _at(data, ["sensors", "*", "camera"], ())]


def _names(value: object) -> list[str]:
    """Return the keys of a mapping; none of anything else."""
    return [str(name) for name in value] if isinstance(value, Mapping) else []


def _at(
    data: object, pattern: Sequence[str], path: tuple[str | int, ...]
) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    if not pattern:
        yield path, data
        return
    step, rest = pattern[0], pattern[1:]
    if isinstance(data, Mapping):
        for key, value in data.items():
            if step == "?":
                yield (*path, key), str(key)
            elif step in ("*", key):
                yield from _at(value, rest, (*path, key))
    elif isinstance(data, list) and step == "*":
        for at, value in enumerate(data):
            yield from _at(value, rest, (*path, at))


def names_of(folder: Path) -> dict[str, list[str]]:
    """Return what may stand in parameters, among other things: `node/parameter`, with `*` for any word, -> names.

    A project whose `grip.yaml` can't be read offers what needs no robot.
    """
    messages = [name for path in (POSES, JOINT_STATES, TRAJECTORIES) for name in _names(data_in(folder / path))]
    found = {
        "messages/*/store": list(STANDARD),
        "messages/*/name": sorted(set(messages)),
        "arm/*/free": FREE,
        "scene/add_shape/shape": SHAPES,
    }
    try:
        project = find_project(folder)
        parts = project_parts_of(project)
    except GripError:  # said where that file is open
        return found
    arms, hands = parts.arms or {}, parts.hands or {}
    found |= {"*/*/arm": list(arms), "*/*/arms": list(arms), "*/*/hand": list(hands)}
    if project.file.robot is None:
        return found
    frames = ("*/*/frame", "ros/lookup_transform/target", "ros/lookup_transform/source")
    found |= dict.fromkeys(frames, list(project_robot_facts(folder).get("frames", ())))
    return found | {
        "arm/*/state": sorted({state for arm in arms.values() for state in arm.known.get("state", ())}),
        "hand/*/posture": sorted({posture for hand in hands.values() for posture in hand.known.get("posture", ())}),
    }
