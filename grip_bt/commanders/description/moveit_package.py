"""What a MoveIt configuration package says besides its robot, and what it prefers in the words of our own settings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from grip_bt.base.errors import DocumentError
from grip_bt.base.issue import Issue
from grip_bt.commanders.settings import SOLVERS

from .configurations import Fitted
from .files import finite, mapping_of, read_yaml, robot_issue
from .robot import Preference

Read = TypeVar("Read")


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

    @property
    def message(self) -> str:
        """The type of what it publishes, as a sensor of a project has it."""
        return "DepthImage" if "DepthImage" in self.plugin else "PointCloud"


@dataclass(frozen=True)
class MoveItPackage:
    """What a package says of one configuration.

    Attributes:
        folder: the package.
        limits: joint -> limits.
        kinematics: group -> MoveIt's plugin.
        planners: group -> OMPL's name of the planner that is used unless told otherwise, such as `RRTConnect`.
        sensors: depth sensors.
        initial_positions: joint -> position [rad or m].
        scaling: `velocity`, `acceleration` -> part of the limits that is used unless told otherwise, in (0, 1].
        findings: files that can't be read, or aren't there.
    """

    folder: Path
    limits: Mapping[str, JointLimits] = field(default_factory=dict)
    kinematics: Mapping[str, str] = field(default_factory=dict)
    planners: Mapping[str, str] = field(default_factory=dict)
    sensors: tuple[Sensor, ...] = ()
    initial_positions: Mapping[str, float] = field(default_factory=dict)
    scaling: Mapping[str, float] = field(default_factory=dict)
    findings: tuple[Issue, ...] = ()


def read_package(folder: Path, chosen: Fitted) -> MoveItPackage:
    """Read what a package says of a configuration besides its robot; what is wrong with files is in `findings`."""
    findings: list[Issue] = []
    words = {chosen.name, chosen.robot.get("name", ""), *map(str, chosen.arguments.values())}
    if chosen.semantic is not None:
        words.add(chosen.semantic.get("name", ""))
    words = {word for word in words if len(word) > 1}
    files = sorted(p for p in folder.rglob("*.yaml") if p.is_file())

    def closeness(path: Path) -> int:
        """Tell how sure it is that a file is about this configuration: it lies by its SRDF, or where its name says."""
        if chosen.srdf is not None and path.parent == chosen.srdf.parent:
            return 3
        if words & {*path.relative_to(folder).parts[:-1]} or any(f"{w}_" in path.stem for w in words):
            return 2
        return int(path.parent == folder / "config")

    def read(of: Callable[[Path], Read], name: str, empty: Read, optional: bool = False) -> Read:
        found = sorted((p for p in files if name in p.stem), key=lambda p: (-closeness(p), p.stem != name))
        if not found or (closeness(found[0]) == 0 and len(found) > 1):
            if not optional:
                findings.append(robot_issue("warning", "missing-file", f"it has no config/{name}.yaml", str(folder)))
            return empty
        try:
            return of(found[0])
        except DocumentError as error:
            message = f"{error.message}; the file is left out"
            findings.append(robot_issue("warning", "bad-file", message, error.source, error.line))
            return empty

    sensors = read(_sensors, "sensors_3d", tuple[Sensor, ...](), optional=True)
    findings += [robot_issue("warning", "sensor-not-read", _how_to_use(sensor), str(folder)) for sensor in sensors]
    return MoveItPackage(
        folder,
        read(_joint_limits, "joint_limits", {}),
        read(_kinematics, "kinematics", {}),
        read(_planners, "ompl_planning", {}),
        sensors,
        read(_initial_positions, "initial_positions", {}, optional=True),
        read(_scaling, "joint_limits", {}, optional=True),
        tuple(findings),
    )


def _joint_limits(path: Path) -> dict[str, JointLimits]:
    """Return joint -> limits; a limit counts where its `has_...` isn't false."""
    found = {}
    for joint, entry in mapping_of(read_yaml(path).get("joint_limits"), "joint_limits", path).items():
        values = mapping_of(entry, f"joint_limits/{joint}", path)
        numbers = {
            name: finite(values[key], f"joint_limits/{joint}/{key}", path)
            for name, key, kind in (
                ("lower", "min_position", "position"),
                ("upper", "max_position", "position"),
                *((kind, f"max_{kind}", kind) for kind in ("velocity", "acceleration", "jerk")),
            )
            if key in values and values.get(f"has_{kind}_limits", True) is True
        }
        found[joint] = JointLimits(**numbers)
    return found


def _scaling(path: Path) -> dict[str, float]:
    data, found = read_yaml(path), {}
    for kind in ("velocity", "acceleration"):
        key = f"default_{kind}_scaling_factor"
        if key in data:
            found[kind] = finite(data[key], key, path)
            if not 0 < found[kind] <= 1:
                wanted = f"is a fraction of the limits: above 0, at most 1, not {data[key]!r}"
                raise DocumentError(f"{key} {wanted}", str(path))
    return found


def _kinematics(path: Path) -> dict[str, str]:
    data: Mapping[str, object] = read_yaml(path)
    data = mapping_of(data.get("robot_description_kinematics", data), "robot_description_kinematics", path)
    groups = {group: mapping_of(entry, group, path) for group, entry in data.items()}
    return {group: str(entry["kinematics_solver"]) for group, entry in groups.items() if "kinematics_solver" in entry}


def _planners(path: Path) -> dict[str, str]:
    data, found = read_yaml(path), {}
    written = mapping_of(data.get("planner_configs"), "planner_configs", path)
    entries = {name: mapping_of(entry, f"planner_configs/{name}", path) for name, entry in written.items()}
    configs = {name: str(entry.get("type", "")).rpartition("::")[2] for name, entry in entries.items()}
    for group, entry in data.items():
        if group != "planner_configs" and isinstance(entry, dict) and "planner_configs" in entry:
            name = str(entry.get("default_planner_config") or USUAL)
            # ROS 1's files call configurations `RRTConnectkConfigDefault`
            found[group] = configs.get(name) or name.removesuffix("Default").removesuffix("kConfig")
    return found


def _sensors(path: Path) -> tuple[Sensor, ...]:
    data = read_yaml(path)
    listed = data.get("sensors") or []
    if not isinstance(listed, list):
        raise DocumentError("sensors has to be a list", str(path))
    found = []
    for item in listed:
        name = item if isinstance(item, str) else ""
        entry = mapping_of(data.get(name) if name else item, "sensors", path)
        if plugin := str(entry.get("sensor_plugin") or ""):
            topic = str(entry.get("point_cloud_topic") or entry.get("image_topic") or "")
            found.append(Sensor(name or str(entry.get("sensor_name") or plugin), plugin, topic))
    return tuple(found)


def _initial_positions(path: Path) -> dict[str, float]:
    entries = mapping_of(read_yaml(path).get("initial_positions"), "initial_positions", path)
    return {joint: finite(value, f"initial_positions/{joint}", path) for joint, value in entries.items()}


def _how_to_use(sensor: Sensor) -> str:
    """Say what a sensor of MoveIt's octomap is here: nothing, until a task looks."""
    topics = f"{{seen: {{topic: {sensor.topic or '/TOPIC'}, type: {sensor.message}}}}}"
    declared = f"`sensors: {{{sensor.name}: {{topics: {topics}, given_in: world}}}}`"
    return (
        f"sensors_3d.yaml: plans don't avoid what {sensor.name} sees by themselves, as MoveIt's with its octomap do; "
        f"declare it in grip.yaml ({declared}), and have a task give what `sensor/{sensor.name}` captures to "
        "`scene/add_cloud`. An arm with `planner: move_group` still has MoveIt's octomap"
    )


USUAL = "RRTConnect"
"""The planner of a group without `default_planner_config`: MoveIt leaves it to OMPL then, whose choice this is, other
than for a group with a `projection_evaluator` (LBKPIECE1)."""
_PLUGINS = (("trac_ik", "trac_ik"), ("kdl", "damped_least_squares"), ("lma", "damped_least_squares"))
"""Part of a plugin's name -> the solver here that works like it."""


def preferences_of(
    package: MoveItPackage, groups: Iterable[str], planners: Iterable[str]
) -> dict[str, dict[str, Preference]]:
    """Return group -> field of an arm (`planner`, `kinematics`, `speed`, `acceleration`) -> what is preferred.

    What there is no equal of here isn't among them; `unknown` of the field's preference then says what was asked for.

    Args:
        package: what its YAML files say.
        planners: names of those that there are here.
    """
    known, found = frozenset(planners), {}
    for group in groups:
        fields: dict[str, Preference] = {}
        if group in package.planners:
            fields["planner"] = _first([package.planners[group]], known, "ompl_planning.yaml")
        if group in package.kinematics:
            plugin = package.kinematics[group]
            solvers = [solver for part, solver in _PLUGINS if part in plugin.lower()]
            fields["kinematics"] = _first([*solvers, plugin], frozenset(SOLVERS), "kinematics.yaml")
        for name, factor in (("speed", "velocity"), ("acceleration", "acceleration")):
            if factor in package.scaling:
                fields[name] = Preference(package.scaling[factor], "joint_limits.yaml")
        found[group] = fields
    return {group: fields for group, fields in found.items() if fields}


def _first(wanted: list[str], known: frozenset[str], source: str) -> Preference:
    value = next((name for name in wanted if name in known), None)
    return Preference(value, source, unknown="" if value else ", ".join(wanted))
