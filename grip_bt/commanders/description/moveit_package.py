"""What a MoveIt configuration package says, and what it prefers in the words of our planners and solvers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

from grip_bt.base.errors import DocumentError, MissingPartError
from grip_bt.commanders.settings import SOLVERS

from . import moveit_files
from .files import Finding, Reading, read_yaml
from .moveit_files import Controller, JointLimits, PlannerChoice, Sensor
from .packages import Packages
from .robot import Preference

ASSISTANT = ".setup_assistant"
Read = TypeVar("Read")


@dataclass(frozen=True)
class MoveItPackage:
    """What a package says.

    Attributes:
        folder: the package.
        layout: `ROS 1` or `ROS 2`.
        urdf: the robot's URDF or xacro file, or None where it can't be told.
        arguments: of a xacro file.
        srdf: SRDF file or its xacro, or None.
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
    urdf: Path | None = None
    arguments: Mapping[str, str] = field(default_factory=dict)
    srdf: Path | None = None
    limits: Mapping[str, JointLimits] = field(default_factory=dict)
    kinematics: Mapping[str, str] = field(default_factory=dict)
    planners: Mapping[str, PlannerChoice] = field(default_factory=dict)
    controllers: tuple[Controller, ...] = ()
    sensors: tuple[Sensor, ...] = ()
    initial_positions: Mapping[str, float] = field(default_factory=dict)
    scaling: Mapping[str, float] = field(default_factory=dict)
    findings: tuple[Finding, ...] = ()


def is_moveit_package(folder: Path) -> bool:
    """Tell whether a folder is one: it has a `.setup_assistant`, or an SRDF in `config/`."""
    return (folder / ASSISTANT).is_file() or bool(_files(folder / "config", "*.srdf", "*.srdf.xacro"))


def read_package(folder: Path, packages: Packages) -> MoveItPackage:
    """Read a package; what is wrong with single files is in `findings`.

    Args:
        packages: where the URDF's package is looked for; this one is always found.

    Raises:
        DocumentError: there is no such folder, or it isn't such a package.
    """
    if not folder.is_dir():
        raise DocumentError("there is no such folder", str(folder))
    if not is_moveit_package(folder):
        raise DocumentError(
            f"isn't a MoveIt configuration package: it has no {ASSISTANT} and no config/*.srdf", str(folder)
        )
    return _Reader(folder, packages).package()


class _Reader:
    def __init__(self, folder: Path, packages: Packages):
        self.folder, self.packages, self.config = folder, packages, folder / "config"
        self.findings: list[Finding] = []

    def package(self) -> MoveItPackage:
        assistant = self._assistant()
        urdf, arguments = self._urdf(assistant)
        controllers: list[Controller] = []
        for path in self._controller_files():
            controllers += self._read(moveit_files.controllers, path, tuple[Controller, ...]())
        sensors = self._read_named(moveit_files.sensors, "sensors_3d.yaml", tuple[Sensor, ...](), optional=True)
        for sensor in sensors:
            self._warn("sensor-not-read", _how_to_use(sensor))
        return MoveItPackage(
            self.folder,
            self._layout(assistant),
            urdf,
            arguments,
            self._srdf(assistant),
            self._read_named(moveit_files.joint_limits, "joint_limits.yaml", {}),
            self._read_named(moveit_files.kinematics, "kinematics.yaml", {}),
            self._read_named(moveit_files.planners, "ompl_planning.yaml", {}),
            tuple({c.name: c for c in reversed(controllers)}.values())[::-1],
            sensors,
            self._read_named(moveit_files.initial_positions, "initial_positions.yaml", {}, optional=True),
            self._read_named(moveit_files.scaling, "joint_limits.yaml", {}, optional=True),
            tuple(self.findings),
        )

    def _layout(self, assistant: Mapping[str, object]) -> str:
        """Tell by what the assistants write: ROS 1's has `URDF:` and catkin, ROS 2's `urdf:` and ament."""
        manifest = self.folder / "package.xml"
        built = manifest.read_text(errors="replace") if manifest.is_file() else ""
        if "catkin" in built or "ament" in built:
            return "ROS 1" if "catkin" in built and "ament" not in built else "ROS 2"
        ros1 = any((self.folder / "launch").glob("*.launch")) or (self.config / "fake_controllers.yaml").is_file()
        return "ROS 1" if ros1 or "URDF" in assistant else "ROS 2"

    def _assistant(self) -> Mapping[str, object]:
        path = self.folder / ASSISTANT
        if not path.is_file():
            return {}
        data = self._read(read_yaml, path, dict[str, object]())
        entry = data.get("moveit_setup_assistant_config", {})
        return entry if isinstance(entry, dict) else {}

    def _urdf(self, assistant: Mapping[str, object]) -> tuple[Path | None, Mapping[str, str]]:
        """ROS 2's packages have a xacro of their own, which adds ros2_control; ROS 1's only name another package's."""
        own = _files(self.config, "*.urdf.xacro", "*.urdf")
        if own:
            return own[0], {}
        entry = self._part(assistant, "urdf")
        relative = str(entry.get("relative_path") or "")
        if not relative:
            self._warn("no-urdf", f"neither {ASSISTANT} nor config/ tells where the URDF is; give it as `urdf:`")
            return None, {}
        arguments = dict(word.split(":=", 1) for word in str(entry.get("xacro_args") or "").split() if ":=" in word)
        package = str(entry.get("package") or "")
        try:
            base = self.packages.find(package) if package else self.folder
        except MissingPartError as error:
            self._warn("no-urdf", f"where the URDF is can't be told: {error}")
            return None, {}
        return base / relative, arguments

    def _srdf(self, assistant: Mapping[str, object]) -> Path | None:
        relative = str(self._part(assistant, "srdf").get("relative_path") or "")
        named = self.folder / relative
        if relative and named.is_file():
            return named
        found = _files(self.config, "*.srdf", "*.srdf.xacro")
        if not found:
            self._warn("no-srdf", "it has no SRDF: no groups, no named states, no disabled collisions")
        return found[0] if found else None

    def _part(self, assistant: Mapping[str, object], name: str) -> Mapping[str, object]:
        """ROS 1 writes `URDF:` and `SRDF:`, ROS 2 `urdf:` and `srdf:`."""
        entry = assistant.get(name) or assistant.get(name.upper())
        return Reading(self.folder / ASSISTANT).mapping(entry, name)

    def _controller_files(self) -> list[Path]:
        files = [p for p in _files(self.config, "*controllers*.yaml") if not p.name.startswith("fake_")]
        return sorted(files, key=lambda p: ("ros" in p.stem.split("_")[0], p.name))

    def _read_named(self, read: Callable[[Path], Read], name: str, empty: Read, optional: bool = False) -> Read:
        path = self.config / name
        if path.is_file():
            return self._read(read, path, empty)
        if not optional:
            self._warn("missing-file", f"it has no config/{name}")
        return empty

    def _read(self, read: Callable[[Path], Read], path: Path, empty: Read) -> Read:
        try:
            return read(path)
        except DocumentError as error:
            self.findings.append(Finding("error", "bad-file", error.message, error.source, error.line))
            return empty

    def _warn(self, code: str, message: str) -> None:
        self.findings.append(Finding("warning", code, message, str(self.folder)))


def _files(folder: Path, *patterns: str) -> list[Path]:
    return [path for pattern in patterns for path in sorted(folder.glob(pattern))]


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
