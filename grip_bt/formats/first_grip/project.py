"""A project folder for a robot's configuration of the first GRIP: `grip.yaml`, messages, sensors, components."""

from __future__ import annotations

import io
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any

from ruamel.yaml import YAML

from grip_bt.base.errors import DocumentError
from grip_bt.base.values.pose import quaternion_of
from grip_bt.base.yaml.tree import parse, read_file, to_data
from grip_bt.formats.imported import Issues, generated_by
from grip_bt.formats.names import key_of

from .tasks import is_hand


@dataclass
class Configuration:
    """What was found: by kind of file, what is said of each name, and the files; and a file of the collision scene."""

    parts: dict[str, dict[str, Any]] = field(default_factory=dict)
    sources: dict[str, list[str]] = field(default_factory=dict)
    scene: Path | None = None
    issues: Issues = field(default_factory=Issues)

    def part(self, kind: str) -> Mapping[str, Any]:
        """Return everything of a kind by name."""
        return self.parts.get(kind, {})


def take_file(found: Configuration, path: Path) -> None:
    """Add a YAML file."""
    try:
        data = to_data(parse(read_file(path), str(path)))
    except DocumentError as error:
        found.issues.add("incomplete", path.name, str(error))
        return
    if not isinstance(data, dict) or not data:
        return
    kind = next((kind for kind, fits in _KINDS.items() if fits(data)), None)
    if kind is None:
        found.issues.add("incomplete", path.name, "none of the formats of the first GRIP: not imported")
        return
    known = found.parts.setdefault(kind, {})
    for name, value in data.items():
        if name in known and known[name] != value:
            text = f"{name!r} is also defined in another file with a different value"
            found.issues.add("incomplete", path.name, text)
        else:
            known[name] = value
    found.sources.setdefault(kind, []).append(path.name)


def _each(test: Callable[[object], bool]) -> Callable[[dict[str, object]], bool]:
    return lambda data: all(test(value) for value in data.values())


def _has(*keys: str) -> Callable[[object], bool]:
    return lambda value: isinstance(value, dict) and set(keys) <= set(value)


_KINDS: dict[str, Callable[[dict[str, object]], bool]] = {
    "hardware": lambda data: "robot_hardware" in data,
    "sensor plugins": lambda data: isinstance(data.get("sensors"), list),
    "poses": _each(_has("reference_frame")),
    "joint_states": _each(
        lambda said: isinstance(said, dict) and bool(said) and all(type(each) in (int, float) for each in said.values())
    ),
    "trajectories": _each(
        lambda said: isinstance(said, list) and bool(said) and all(map(_has("name", "interpolate_time"), said))
    ),
    "components": _each(_has("action/service")),
    "planners": _each(_has("planner_name")),
    "sensors": _each(_has("data_topics")),
    "controllers": _each(_has("type")),
}


_TYPES = (
    (("point", "cloud", "pc"), "PointCloud"),
    (("info",), "CameraInfo"),
    (("depth",), "DepthImage"),
    (("image", "rgb", "color", "colour"), "Image"),
    (("joint",), "JointState"),
)


def sensor_entry(name: str, said: Mapping[str, object], found: Configuration) -> dict[str, object] | None:
    """Return a sensor as `grip.yaml` has it; None where it has no topic."""
    given = said["data_topics"]
    topics = {}
    for alias, topic in given.items() if isinstance(given, dict) else ():
        type_name = _type(str(alias), str(topic))
        if type_name is None:
            text = f"the message type of topic {topic} is unknown: add it to `sensors`, with its type"
            found.issues.add("incomplete", name, text)
            continue
        found.issues.add("changed", name, f"{alias}: {type_name}, by the names of alias and topic")
        topics[key_of(str(alias))] = {"topic": "/" + str(topic).strip("/"), "type": type_name}
    if not topics:
        return None
    made: dict[str, object] = {"topics": topics}
    pose = said.get("initial_pose")
    pose = found.part("poses").get(pose) if isinstance(pose, str) else pose
    if said.get("frame_id") and isinstance(pose, dict):
        made["mount"] = _mount(name, str(said["frame_id"]), pose, found)
    elif said.get("initial_pose"):
        found.issues.add("incomplete", name, f"where it is ({said['initial_pose']!r}) isn't known; add `mount`")
    if said.get("launch_file"):
        found.issues.add("incomplete", name, f"{said['launch_file']} is of ROS 1: start its ROS 2 driver, or `driver`")
    return {key: value for key, value in made.items() if value}


def _type(alias: str, topic: str) -> str | None:
    texts = (alias.lower(), topic.lower())
    found = (kind for text in texts for words, kind in _TYPES if any(word in text for word in words))
    return next(found, None)


def _mount(name: str, frame: str, pose: Mapping[str, Any], found: Configuration) -> dict[str, Any] | None:
    try:
        position = [float(pose["position"][axis]) for axis in "xyz"]
        turn = pose["orientation"]
        if "w" in turn:
            quaternion = [float(turn[axis]) for axis in "wxyz"]
        else:
            quaternion = list(quaternion_of(*(float(turn[axis]) for axis in "rpy")))
    except (KeyError, TypeError, ValueError) as error:
        found.issues.add("incomplete", name, f"its pose can't be read ({error}); add `mount`")
        return None
    on = str(pose.get("reference_frame", "world"))
    return {"frame": frame, "on": on, "position": position, "quaternion": quaternion}


MARK = generated_by("grip")
MESSAGES = ("joint_states", "poses", "trajectories")


def project_texts(found: Configuration, moving: Collection[str] = ()) -> dict[str, str]:
    """Return the files of a project folder; `moving`: kinds of nodes that the tasks use, of `arm`, `hand`, `scene`."""
    texts = {"grip.yaml": _yaml_text(_project(found, moving))}
    for kind in MESSAGES:
        if found.part(kind):
            texts[f"messages/{kind}.yaml"] = _yaml_text(dict(found.part(kind)), flow=True)
    for name, said in found.part("components").items():
        entry = component_entry(name, said, found.issues)
        if entry is not None:
            texts[f"components/{entry['name']}/component.yaml"] = _yaml_text(entry)
    for kind, what in (
        ("controllers", "controllers of ROS 1: configure ros2_control"),
        ("hardware", "the hardware connection of ROS 1: start the ROS 2 driver, for instance as one of `processes`"),
        ("sensor plugins", "plug-ins of move_group: `scene/update_from_cloud` puts what a camera sees into the scene"),
    ):
        if found.part(kind):
            found.issues.add("incomplete", ", ".join(found.sources[kind]), f"{what}; not imported")
    return texts


def _project(found: Configuration, moving: Collection[str]) -> dict[str, Any]:
    made: dict[str, object] = {"grip": 1, "doc": "Imported from a configuration of the first GRIP."}
    arms: dict[str, dict[str, object]] = {}
    hands: dict[str, dict[str, object]] = {}
    for group, said in found.part("planners").items():
        if is_hand(group):
            hands[key_of(group)] = {"group": group}
            text = "treated as a hand because of its name; no motions are planned for hands"
            found.issues.add("changed", group, text)
        else:
            arms[key_of(group)] = _arm(group, said, found.issues)
    for part, there in (("arm", arms), ("hand", hands)):
        if moving and not there:
            there[part] = {"group": part}
            found.issues.add(
                "changed", "grip.yaml", f"no configuration names {part}s: `{part}` is assumed; name the robot"
            )
    if len(arms) == len(hands) == 1:
        next(iter(arms.values()))["hand"] = next(iter(hands))
    sensors = {key_of(name): sensor_entry(name, said, found) for name, said in found.part("sensors").items()}
    sensors = {key: entry for key, entry in sensors.items() if entry}
    made |= {key: parts for key, parts in (("arms", arms), ("hands", hands), ("sensors", sensors)) if parts}
    if found.scene is not None:
        made["scene"] = found.scene.name
    return made


def _arm(group: str, said: Mapping[str, object], issues: Issues) -> dict[str, object]:
    planner = str(said["planner_name"])
    planner = planner.removesuffix("kConfigDefault").removesuffix("ConfigDefault")
    made: dict[str, object] = {"group": group, "planner": planner}
    for key, name in (
        ("robot_speed_factor", "speed"),
        ("number_plan_attempt", "attempts"),
        ("planning_max_time", "planning_time"),
    ):
        value = said.get(key)
        if isinstance(value, int | float) and not isinstance(value, bool) and value > 0:
            made[name] = int(value) if name == "attempts" else float(value)
        elif value is not None:
            issues.add("incomplete", group, f"{key} is {value!r} and not a number above 0; the default is used")
    return made


def component_entry(name: str, said: Mapping[str, object], issues: Issues) -> dict[str, Any] | None:
    """Return the component file of an external component; None where its interface can't be told."""
    path = PurePosixPath(str(said["action/service"]))
    kind = {".action": "action", ".srv": "srv"}.get(path.suffix)
    if kind is None or len(path.parts) < 3 or not path.stem[:1].isupper():
        text = f"{path}: PACKAGE/{{action,srv}}/Name.{{action,srv}} is expected; the component isn't imported"
        issues.add("incomplete", name, text)
        return None
    number, count = said.get("number_outcomes"), outcome_count(said)
    if count != number:
        issues.add("incomplete", name, f"number_outcomes is {number!r}; one outcome is assumed")
    key, package = key_of(name), key_of(path.parts[-3])
    made: dict[str, Any] = {
        "name": key,
        "doc": f"{name}, an external component of the first GRIP.",
        "interface": f"{package}/{kind}/{path.stem}",
        "server": "/" + str(said.get("server_name", key)).strip("/"),
        "outcomes": count,
    }
    program = str(said.get("node_type") or PurePosixPath(str(said.get("file", ""))).name)
    if program:
        owner = PurePosixPath(str(said.get("file", "")))
        below = owner.parts[owner.parts.index("src") + 1 :] if "src" in owner.parts else ()
        # the package is the folder below `src`
        made["start"] = {"package": below[0] if below[1:] else package, "executable": program, "run": False}
    text = "its server is one of ROS 1: port it to ROS 2, set `run: true`"
    issues.add("incomplete", name, f"{text}, and run `grip component add components/{key}` for its node")
    if said.get("run_node") is False:
        issues.add("changed", name, "run_node: false is respected")
    return made


def outcome_count(said: Mapping[str, object]) -> int:
    """Return how many outcomes an external component has; one where that isn't said."""
    number = said.get("number_outcomes")
    return number if type(number) is int and 0 < number < 100 else 1


def _yaml_text(data: Mapping[str, object], flow: bool = False) -> str:
    yaml, text = YAML(), io.StringIO()
    yaml.default_flow_style = None if flow else False
    yaml.width = 120
    yaml.dump(dict(data), text)
    return f"# {MARK}.\n{text.getvalue()}"
