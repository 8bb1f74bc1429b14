"""What a MoveIt configuration package says, and what it prefers in the words of our planners and solvers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

from grip_bt.base.errors import DocumentError
from grip_bt.commanders.settings import SOLVERS

from . import moveit_files
from .configurations import Fitted
from .files import Finding
from .moveit_files import Controller, JointLimits, PlannerChoice, Sensor
from .robot import Preference

Read = TypeVar("Read")


@dataclass(frozen=True)
class MoveItPackage:
    """What a package says of one configuration.

    Attributes:
        folder: the package.
        layout: `ROS 1` or `ROS 2`.
        limits: joint -> limits.
        kinematics: group -> MoveIt's plugin.
        planners: group -> planners.
        controllers: of all `*controllers.yaml`; MoveIt's own before those of ros_control.
        sensors: depth sensors.
        initial_positions: joint -> position [rad or m].
        scaling: `velocity`, `acceleration` -> part of the limits that is used unless told otherwise, in (0, 1].
        findings: files that can't be read, or aren't there.
    """

    folder: Path
    layout: str
    limits: Mapping[str, JointLimits] = field(default_factory=dict)
    kinematics: Mapping[str, str] = field(default_factory=dict)
    planners: Mapping[str, PlannerChoice] = field(default_factory=dict)
    controllers: tuple[Controller, ...] = ()
    sensors: tuple[Sensor, ...] = ()
    initial_positions: Mapping[str, float] = field(default_factory=dict)
    scaling: Mapping[str, float] = field(default_factory=dict)
    findings: tuple[Finding, ...] = ()


def read_package(folder: Path, chosen: Fitted) -> MoveItPackage:
    """Read what a package says of a configuration besides its robot; what is wrong with files is in `findings`."""
    return _Reader(folder, chosen).package()


class _Reader:
    def __init__(self, folder: Path, chosen: Fitted):
        self.folder, self.chosen = folder, chosen
        self.findings: list[Finding] = []
        words = {chosen.name, chosen.robot.get("name", ""), *map(str, chosen.arguments.values())}
        if chosen.semantic is not None:
            words.add(chosen.semantic.get("name", ""))
        self.words = {word for word in words if len(word) > 1}
        self.files = sorted(p for p in folder.rglob("*.yaml") if p.is_file())

    def package(self) -> MoveItPackage:
        controllers: list[Controller] = []
        for path in self._controller_files():
            controllers += self._read(moveit_files.controllers, path, tuple[Controller, ...]())
        sensors = self._read_named(moveit_files.sensors, "sensors_3d", tuple[Sensor, ...](), optional=True)
        for sensor in sensors:
            self._warn("sensor-not-read", _how_to_use(sensor))
        return MoveItPackage(
            self.folder,
            self._layout(),
            self._read_named(moveit_files.joint_limits, "joint_limits", {}),
            self._read_named(moveit_files.kinematics, "kinematics", {}),
            self._read_named(moveit_files.planners, "ompl_planning", {}),
            tuple({c.name: c for c in reversed(controllers)}.values())[::-1],
            sensors,
            self._read_named(moveit_files.initial_positions, "initial_positions", {}, optional=True),
            self._read_named(moveit_files.scaling, "joint_limits", {}, optional=True),
            tuple(self.findings),
        )

    def _layout(self) -> str:
        """Tell by what the assistants write: ROS 1's packages have catkin and launch files in XML."""
        manifest = self.folder / "package.xml"
        built = manifest.read_text(errors="replace") if manifest.is_file() else ""
        if "catkin" in built or "ament" in built:
            return "ROS 1" if "catkin" in built and "ament" not in built else "ROS 2"
        ros1 = (self.folder / "config" / "fake_controllers.yaml").is_file()
        return "ROS 1" if ros1 or any((self.folder / "launch").glob("*.launch")) else "ROS 2"

    def _controller_files(self) -> list[Path]:
        found = [p for p in self.files if "controllers" in p.stem and "fake" not in str(p.relative_to(self.folder))]
        closest = max(map(self._closeness, found), default=0)
        files = [p for p in found if self._closeness(p) == closest]
        return sorted(files, key=lambda p: ("ros" in p.stem.split("_")[0], p.name))

    def _closeness(self, path: Path) -> int:
        """Tell how sure it is that a file is about this configuration: it lies by its SRDF, or where its name says."""
        if self.chosen.srdf is not None and path.parent == self.chosen.srdf.parent:
            return 3
        if self.words & {*path.relative_to(self.folder).parts[:-1]} or any(f"{w}_" in path.stem for w in self.words):
            return 2
        return int(path.parent == self.folder / "config")

    def _read_named(self, read: Callable[[Path], Read], name: str, empty: Read, optional: bool = False) -> Read:
        found = sorted((p for p in self.files if name in p.stem), key=lambda p: (-self._closeness(p), p.stem != name))
        if found and (self._closeness(found[0]) > 0 or len(found) == 1):
            return self._read(read, found[0], empty)
        if not optional:
            self._warn("missing-file", f"it has no config/{name}.yaml")
        return empty

    def _read(self, read: Callable[[Path], Read], path: Path, empty: Read) -> Read:
        try:
            return read(path)
        except DocumentError as error:
            message = f"{error.message}; the file is left out"
            self.findings.append(Finding("warning", "bad-file", message, error.source, error.line))
            return empty

    def _warn(self, code: str, message: str) -> None:
        self.findings.append(Finding("warning", code, message, str(self.folder)))


def _how_to_use(sensor: moveit_files.Sensor) -> str:
    """Say what a sensor of MoveIt's octomap is here: nothing, until a task looks."""
    kind = "DepthImage" if "DepthImage" in sensor.plugin else "PointCloud"
    topics = f"{{seen: {{topic: {sensor.topic or '/TOPIC'}, type: {kind}}}}}"
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
            choice = package.planners[group]
            default = choice.planners.get(choice.default, choice.default)
            fields["planner"] = replace(
                _first([default or USUAL], known, "ompl_planning.yaml"), parameters=_parameters(choice, known)
            )
        if group in package.kinematics:
            plugin = package.kinematics[group]
            solvers = [solver for part, solver in _PLUGINS if part in plugin.lower() and solver in SOLVERS]
            fields["kinematics"] = _first([*solvers, plugin], frozenset(SOLVERS), "kinematics.yaml")
        for name, factor in (("speed", "velocity"), ("acceleration", "acceleration")):
            if factor in package.scaling:
                fields[name] = Preference(package.scaling[factor], "joint_limits.yaml")
        found[group] = fields
    return {group: fields for group, fields in found.items() if fields}


def _parameters(choice: PlannerChoice, known: frozenset[str]) -> dict[str, dict[str, float]]:
    """Return planner -> its parameters; of several configurations of one planner, the default or else the first."""
    order = sorted(choice.planners, key=lambda name: name != choice.default)
    found: dict[str, dict[str, float]] = {}
    for name in order:
        if choice.planners[name] in known:
            found.setdefault(choice.planners[name], dict(choice.parameters.get(name, {})))
    return {planner: parameters for planner, parameters in found.items() if parameters}


def _first(wanted: list[str], known: frozenset[str], source: str) -> Preference:
    value = next((name for name in wanted if name in known), None)
    return Preference(value, source, unknown="" if value else ", ".join(wanted))
