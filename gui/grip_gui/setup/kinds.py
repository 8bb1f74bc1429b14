"""What settings files there are: where they lie, their shape, and templates to begin with."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from grip_bt.app.project.folder import ProjectFile
from grip_bt.base.errors import DocumentError
from grip_bt.base.message_store.files import read_joint_states, read_poses, read_trajectories
from grip_bt.base.yaml.models import Diagnostic, check_model
from grip_bt.base.yaml.tree import YamlValue
from grip_bt.task.catalog.component_file import ComponentFile
from grip_gui.project import OutsideProjectError, ProjectFolder
from grip_gui.wire.setup import SetupEntry, Template

JOINT_STATES, POSES, TRAJECTORIES = (f"messages/{name}.yaml" for name in ("joint_states", "poses", "trajectories"))
_NUMBER, _TEXT = {"type": "number"}, {"type": "string"}
_NUMBERS = {"type": "object", "additionalProperties": _NUMBER}
_POSITION = {"type": "object", "properties": dict.fromkeys("xyz", _NUMBER), "title": "Position [m]"}
_TURN = {"type": "object", "properties": dict.fromkeys("rpy", _NUMBER), "title": "Roll, pitch, yaw [rad]"}
_POSE = {"type": "object", "properties": {"reference_frame": _TEXT, "position": _POSITION, "orientation": _TURN}}
_TIMES = {"interpolate_time": _NUMBER, "pause_time": _NUMBER}
_WAYPOINT = {"type": "object", "properties": {**_TIMES, "name": _TEXT}}


@dataclass(frozen=True)
class Kind:
    """One kind of settings file, `name` on the wire."""

    name: str
    title: str
    doc: str
    shape: Mapping[str, Any]
    """JSON Schema of its data."""
    blank: str
    """The text of a new file."""
    check: Callable[[Path, str, YamlValue], list[Diagnostic]]
    """Returns what is wrong with a text that is YAML."""
    templates: Sequence[Template] = ()
    """Values to begin with."""


def _by_model(model: type[BaseModel]) -> Callable[[Path, str, YamlValue], list[Diagnostic]]:
    return lambda _file, _text, tree: check_model(tree, model)[1]


def _by_reader(read: Callable[[Path, str], object]) -> Callable[[Path, str, YamlValue], list[Diagnostic]]:
    """Check by the room that reads such files, beside those that it refers to."""

    def check(file: Path, text: str, _tree: YamlValue) -> list[Diagnostic]:
        try:
            read(file, text)
        except DocumentError as error:
            return [(error.message, error.line or 1, error.column or 1)]
        return []

    return check


def _trajectories(file: Path, text: str) -> object:
    states = file.with_name("joint_states.yaml")
    return read_trajectories(file, read_joint_states(states) if states.is_file() else {}, text)


def _template(title: str, *key: str, value: object) -> Template:
    return Template(title=title, key=list(key), value=value)


_ABOVE = {
    "reference_frame": "world",
    "position": dict.fromkeys("xyz", 0.4) | {"y": 0.0},
    "orientation": dict.fromkeys("rpy", 0.0),
}
_CLOUD = {"cloud": {"topic": "/camera/points", "type": "PointCloud"}}
_DESCRIBED = {"xacro": "robot.urdf.xacro", "arguments": {"prefix": "left_"}, "srdf": "robot.srdf"}
_MOUNTED = {"arm": "ur5", "hand": "allegro_right", "mount": {"link": "tool0", "xyz": [0.0, 0.0, 0.15]}}
_LAUNCHED = {"package": "my_robot_bringup", "launch": "robot.launch.py", "arguments": {"use_sim": "false"}}
PROJECT = Kind(
    "project",
    "Robot, sensors, processes",
    "The robot with its arms and hands, how they plan, the sensors, and what runs beside.",
    ProjectFile.model_json_schema(),
    "grip: 1\n",
    _by_model(ProjectFile),
    (
        _template("Panda with an Allegro hand", "robot", value="panda_allegro"),
        _template("a robot from a URDF or xacro file", "robot", value=_DESCRIBED),
        _template("a robot from a MoveIt package", "robot", value={"moveit": "src/my_robot_moveit_config"}),
        _template("a hand on an arm", "robot", value=_MOUNTED),
        _template("an arm with a hand", "arms", "right", value={"group": "arm", "hand": "right_hand"}),
        _template("a hand", "hands", "right_hand", value={"group": "hand"}),
        _template("a camera of the simulated world", "sensors", "overhead", value={"camera": "overhead"}),
        _template("a depth sensor on topics", "sensors", "depth", value={"topics": _CLOUD}),
        _template("the simulated table", "world", value="table"),
        _template("a process", "processes", "driver", value={"command": ["{python}", "driver.py"]}),
        _template("a launch file", "processes", "bringup", value=_LAUNCHED),
    ),
)
COMPONENT = Kind(
    "component",
    "Component",
    "Software of others, called as a service or an action: its outcomes, ports, start and time-outs.",
    ComponentFile.model_json_schema(),
    "",
    _by_model(ComponentFile),
    (
        _template("started by a command", "start", value={"command": ["{python}", "server.py"]}),
        _template("time-outs", "timeouts", value={"call": 60.0, "ready": 60.0}),
    ),
)
_MESSAGES = {
    JOINT_STATES: Kind(
        "joint_states",
        "Named joint states",
        "Name -> joint -> position [rad or m].",
        {"type": "object", "additionalProperties": _NUMBERS},
        "{}\n",
        _by_reader(read_joint_states),
        (_template("a joint state", "home", value={"joint_1": 0.0}),),
    ),
    POSES: Kind(
        "poses",
        "Named poses",
        "Name -> frame, position [m], orientation [rad].",
        {"type": "object", "additionalProperties": _POSE},
        "{}\n",
        _by_reader(read_poses),
        (_template("a pose", "above_table", value=_ABOVE),),
    ),
    TRAJECTORIES: Kind(
        "trajectories",
        "Named trajectories",
        "Name -> joint states by name, with the time to each and the pause there [s].",
        {"type": "object", "additionalProperties": {"type": "array", "items": _WAYPOINT}},
        "{}\n",
        _by_reader(_trajectories),
    ),
}
_COMPONENT_PATH = re.compile(r"^[A-Za-z0-9_./-]+/[A-Za-z0-9_-]+/component\.yaml$|^[A-Za-z0-9_-]+/component\.yaml$")


def kind_of(path: str) -> Kind:
    """Return what a file is by its path; one that is none of a project's settings files is refused."""
    if path == "grip.yaml":
        return PROJECT
    if path in _MESSAGES:
        return _MESSAGES[path]
    if _COMPONENT_PATH.match(path):
        return COMPONENT
    raise OutsideProjectError(path, f"isn't a settings file (available: grip.yaml, {', '.join(_MESSAGES)}, components)")


def entries(folder: ProjectFolder, components: Mapping[str, Path]) -> list[SetupEntry]:
    """Return all settings files of a project, those that could be made among them."""
    paths = {"grip.yaml": PROJECT, **_MESSAGES}
    found = [(path, kind, kind.title) for path, kind in paths.items()]
    for name, home in components.items():
        path = folder.relative(home / "component.yaml")
        found.insert(1, (path, COMPONENT, f"Component {name}"))
    return [
        SetupEntry(path=path, kind=kind.name, title=title, exists=(folder.folder / path).is_file(), doc=kind.doc)
        for path, kind, title in found
    ]
