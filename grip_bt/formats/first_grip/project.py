"""A project folder for what was imported: `grip.yaml`, messages, components, tasks, nodes to be filled in."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import Any

from ruamel.yaml import YAML

from grip_bt.formats.generated_files import generated_by
from grip_bt.formats.imported import Issues
from grip_bt.formats.names import key_of

from .configuration import Configuration
from .sensors import sensor_entry
from .words import is_hand

MARK = generated_by("grip")
MESSAGES = ("joint_states", "poses", "trajectories")


def project_texts(found: Configuration) -> dict[str, str]:
    """Return the files of a project folder by their path in it; what isn't as it was is noted in `found`."""
    texts = {"grip.yaml": _yaml(_project(found))}
    for kind in MESSAGES:
        if found.part(kind):
            texts[f"messages/{kind}.yaml"] = _yaml(dict(found.part(kind)), flow=True)
    for name, said in found.part("components").items():
        entry = component_entry(name, said, found.issues)
        if entry is not None:
            texts[f"components/{entry['name']}/component.yaml"] = _yaml(entry)
    for kind, what in (
        ("controllers", "controllers of ROS 1: configure ros2_control"),
        ("hardware", "the hardware connection of ROS 1: start the ROS 2 driver, for instance as one of `processes`"),
        ("sensor plugins", "plug-ins of move_group: `scene/update_from_cloud` puts what a camera sees into the scene"),
    ):
        if found.part(kind):
            found.issues.add("incomplete", ", ".join(found.sources[kind]), f"{what}; not imported")
    return texts


def _project(found: Configuration) -> dict[str, Any]:
    made: dict[str, Any] = {"grip": 1, "doc": "Imported from a configuration of the first GRIP."}
    arms, hands = {}, {}
    for group, said in found.part("planners").items():
        if is_hand(group):
            hands[key_of(group)] = {"group": group}
            found.issues.add(
                "changed", group, "treated as a hand because of its name; no motions are planned for hands"
            )
        else:
            arms[key_of(group)] = _arm(group, said, found.issues)
    sensors = {key_of(name): sensor_entry(name, said, found) for name, said in found.part("sensors").items()}
    for key, value in (("arms", arms), ("hands", hands), ("sensors", {k: v for k, v in sensors.items() if v})):
        if value:
            made[key] = value
    if found.scene is not None:
        made["scene"] = found.scene.name
    return made


def _arm(group: str, said: Mapping[str, Any], issues: Issues) -> dict[str, Any]:
    planner = str(said["planner_name"])
    planner = planner.removesuffix("kConfigDefault").removesuffix("ConfigDefault")
    made: dict[str, Any] = {"group": group, "planner": planner}
    for key, name in (
        ("robot_speed_factor", "speed"),
        ("number_plan_attempt", "attempts"),
        ("planning_max_time", "planning_time"),
    ):
        value = said.get(key)
        if isinstance(value, int | float) and not isinstance(value, bool) and value > 0:
            made[name] = int(value) if name == "attempts" else float(value)
        elif value is not None:
            issues.add("incomplete", group, f"{key} is {value!r} and no number above 0; the default is used")
    return made


def component_entry(name: str, said: Mapping[str, Any], issues: Issues) -> dict[str, Any] | None:
    """Return the component file of an external component; None where its interface can't be told."""
    path = PurePosixPath(str(said["action/service"]))
    kind = {".action": "action", ".srv": "srv"}.get(path.suffix)
    if kind is None or len(path.parts) < 3 or not path.stem[:1].isupper():
        text = f"{path}: PACKAGE/{{action,srv}}/Name.{{action,srv}} is expected; the component isn't imported"
        issues.add("incomplete", name, text)
        return None
    number = said.get("number_outcomes")
    count = number if type(number) is int and 0 < number < 100 else 1
    if count != number:
        issues.add("incomplete", name, f"number_outcomes is {number!r}; one outcome is taken")
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
        made["start"] = {"package": _package(owner, package), "executable": program, "run": False}
    text = "its server is one of ROS 1: port it to ROS 2, set `run: true`"
    issues.add("incomplete", name, f"{text}, and run `grip component add components/{key}` for its node")
    if said.get("run_node") is False:
        issues.add("changed", name, "run_node: false is respected")
    return made


def _package(file: PurePosixPath, otherwise: str) -> str:
    """Return the package that a server's file is in: the folder below `src`."""
    parts = file.parts
    if "src" in parts and parts.index("src") + 2 < len(parts):
        return parts[parts.index("src") + 1]
    return otherwise


def _yaml(data: Mapping[str, Any], flow: bool = False) -> str:
    yaml, text = YAML(), io.StringIO()
    yaml.default_flow_style = None if flow else False
    yaml.width = 120
    yaml.dump(dict(data), text)
    return f"# {MARK}.\n{text.getvalue()}"
