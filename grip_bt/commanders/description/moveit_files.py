"""The YAML files of a MoveIt configuration package, as values; each reader raises DocumentError for another file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path

from grip_bt.base.errors import DocumentError

from .files import Reading, read_yaml


@dataclass(frozen=True, slots=True)
class JointLimits:
    """What `joint_limits.yaml` adds to the URDF's limits of a joint; None where it says nothing.

    Attributes:
        lower: [rad or m].
        upper: [rad or m].
        velocity: [rad/s or m/s].
        acceleration: [rad/s^2 or m/s^2].
        jerk: [rad/s^3 or m/s^3].
    """

    lower: float | None = None
    upper: float | None = None
    velocity: float | None = None
    acceleration: float | None = None
    jerk: float | None = None


@dataclass(frozen=True, slots=True)
class PlannerChoice:
    """A group's planners in `ompl_planning.yaml`.

    Attributes:
        default: configuration that is used unless told otherwise, or empty.
        planners: configuration -> OMPL's name of its planner, such as `RRTConnect`.
        parameters: configuration -> parameter, such as `range` or `goal_bias` -> number.
    """

    default: str
    planners: Mapping[str, str]
    parameters: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Controller:
    """A controller that moves joints.

    Attributes:
        name: its name.
        type: `FollowJointTrajectory`, `GripperCommand`, or a class of ros_control.
        action: its action's namespace below the name, or empty.
        joints: what it moves.
        default: whether it is the one to take.
    """

    name: str
    type: str
    action: str
    joints: tuple[str, ...]
    default: bool = False


@dataclass(frozen=True, slots=True)
class Sensor:
    """A depth sensor that fills MoveIt's octomap.

    Attributes:
        name: its name, or its plugin where it has none.
        plugin: MoveIt's class.
        topic: of clouds or depth images.
    """

    name: str
    plugin: str
    topic: str


def joint_limits(path: Path) -> dict[str, JointLimits]:
    """Return the limits of `joint_limits.yaml`; a limit counts where its `has_...` isn't false."""
    reading = Reading(path)
    found = {}
    for joint, entry in reading.mapping(read_yaml(path).get("joint_limits"), "joint_limits").items():
        values = reading.mapping(entry, f"joint_limits/{joint}")

        def limit(key: str, kind: str, joint: str = joint, values: Mapping[str, object] = values) -> float | None:
            if values.get(f"has_{kind}_limits", key in values) is not True or key not in values:
                return None
            return reading.number(values[key], f"joint_limits/{joint}/{key}")

        found[joint] = JointLimits(
            limit("min_position", "position"),
            limit("max_position", "position"),
            limit("max_velocity", "velocity"),
            limit("max_acceleration", "acceleration"),
            limit("max_jerk", "jerk"),
        )
    return found


def scaling(path: Path) -> dict[str, float]:
    """Return `velocity` and `acceleration` -> default part of the limits, in (0, 1], of `joint_limits.yaml`."""
    reading, data, found = Reading(path), read_yaml(path), {}
    for kind in ("velocity", "acceleration"):
        key = f"default_{kind}_scaling_factor"
        if key in data:
            found[kind] = reading.number(data[key], key)
            if not 0 < found[kind] <= 1:
                raise DocumentError(
                    f"{key} is a fraction of the limits: above 0, at most 1, not {data[key]!r}", str(path)
                )
    return found


def kinematics(path: Path) -> dict[str, str]:
    """Return group -> MoveIt's kinematics plugin, of `kinematics.yaml`."""
    reading, data = Reading(path), read_yaml(path)
    data = dict(reading.mapping(data.get("robot_description_kinematics", data), "robot_description_kinematics"))
    groups = {group: reading.mapping(entry, group) for group, entry in data.items()}
    return {group: str(entry["kinematics_solver"]) for group, entry in groups.items() if "kinematics_solver" in entry}


def planners(path: Path) -> dict[str, PlannerChoice]:
    """Return group -> its planners, of `ompl_planning.yaml`."""
    reading, data = Reading(path), read_yaml(path)
    entries = {
        name: reading.mapping(entry, f"planner_configs/{name}")
        for name, entry in reading.mapping(data.get("planner_configs"), "planner_configs").items()
    }
    configs = {name: str(entry.get("type", "")).rpartition("::")[2] for name, entry in entries.items()}
    found = {}
    for group, entry in data.items():
        if group == "planner_configs" or not isinstance(entry, dict) or "planner_configs" not in entry:
            continue
        names = reading.words(entry["planner_configs"], f"{group}/planner_configs")
        # ROS 1's files call configurations `RRTConnectkConfigDefault`
        chosen = {name: configs.get(name) or name.removesuffix("Default").removesuffix("kConfig") for name in names}
        parameters = {name: _numbers(entries.get(name, {})) for name in names}
        found[group] = PlannerChoice(str(entry.get("default_planner_config") or ""), chosen, parameters)
    return found


def _numbers(entry: Mapping[str, object]) -> dict[str, float]:
    """Return the entries that are finite numbers; those of others, such as a projection, OMPL's planners don't take."""
    return {
        str(name): float(value) for name, value in entry.items() if isinstance(value, int | float) and isfinite(value)
    }


def controllers(path: Path) -> tuple[Controller, ...]:
    """Return the controllers of a `*controllers.yaml`, whichever of MoveIt's and ros_control's forms it has."""
    reading, data = Reading(path), read_yaml(path)
    listed = data.get("controller_list")
    if isinstance(listed, list):
        entries = [reading.mapping(entry, "controller_list") for entry in listed]
        return tuple(_controller(str(reading.known("name", e, "controller_list")), e, reading) for e in entries)
    manager = reading.mapping(data.get("moveit_simple_controller_manager"), "moveit_simple_controller_manager")
    names = reading.words(manager.get("controller_names"), "controller_names")
    found = [
        _controller(name, reading.mapping(reading.known(name, manager, "the manager"), name), reading) for name in names
    ]
    if not found:
        found = [_controller(name, entry, reading) for name, entry in _with_joints(data)]
    return tuple(found)


def sensors(path: Path) -> tuple[Sensor, ...]:
    """Return the sensors of `sensors_3d.yaml`."""
    reading, data = Reading(path), read_yaml(path)
    entries: list[tuple[str, Mapping[str, object]]] = []
    listed = data.get("sensors") or []
    if not isinstance(listed, list):
        raise DocumentError("sensors has to be a list", str(path))
    for item in listed:
        named = isinstance(item, str)
        entries.append((str(item) if named else "", reading.mapping(data.get(item) if named else item, "sensors")))
    return tuple(
        Sensor(
            name or str(entry.get("sensor_name") or entry.get("sensor_plugin", "sensor")),
            str(entry.get("sensor_plugin", "")),
            str(entry.get("point_cloud_topic") or entry.get("image_topic") or ""),
        )
        for name, entry in entries
        if entry.get("sensor_plugin")
    )


def initial_positions(path: Path) -> dict[str, float]:
    """Return joint -> position at the start, of `initial_positions.yaml`."""
    reading = Reading(path)
    entries = reading.mapping(read_yaml(path).get("initial_positions"), "initial_positions")
    return {joint: reading.number(value, f"initial_positions/{joint}") for joint, value in entries.items()}


def _controller(name: str, entry: Mapping[str, object], reading: Reading) -> Controller:
    joints = entry.get("joints") or ([entry["joint"]] if "joint" in entry else [])
    return Controller(
        name,
        str(entry.get("type", "")),
        str(entry.get("action_ns", "")),
        reading.words(joints, f"{name}/joints"),
        entry.get("default") is True,
    )


def _with_joints(data: Mapping[str, object]) -> Iterator[tuple[str, Mapping[str, object]]]:
    """Yield what has joints, wherever: ros_control's files name controllers at the top, ROS 2's below parameters.

    ROS 2 tells a controller's type in its manager's part of the file.
    """
    manager = data.get("controller_manager")
    types = manager.get("ros__parameters") if isinstance(manager, dict) else None
    for name, entry in data.items():
        inner = entry.get("ros__parameters", entry) if isinstance(entry, dict) else None
        if isinstance(inner, dict) and ("joints" in inner or "joint" in inner):
            known = types.get(name) if isinstance(types, dict) else None
            yield name, {**(known if isinstance(known, dict) else {}), **inner}
