"""A new project for a robot: which of a workspace's configurations it is, and the few lines that say so."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import yaml

from grip_bt.app.project.first_motions import BENCH, FirstMotions, MotionFinder, first_grasp
from grip_bt.base.errors import DocumentError, InvalidRobotError, UnknownNameError
from grip_bt.base.issue import Issue
from grip_bt.base.values import JointState
from grip_bt.commanders.description.config import RobotConfig
from grip_bt.commanders.description.configurations import Configurations, configured_packages
from grip_bt.commanders.description.files import errors
from grip_bt.commanders.description.from_files import Inspected
from grip_bt.commanders.description.launched import is_launch_file
from grip_bt.commanders.description.load import PROJECT, config_of, inspect_robot
from grip_bt.commanders.description.packages import MANIFEST, ROBOTS, Packages, name_of_package, package_around
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.description.roles import arms_of
from grip_bt.commanders.scene_state import SceneSnapshot
from grip_bt.task import fmt

FILES = ("urdf", "xacro", "srdf", "moveit")
"""Keys of `robot:` that name a file or a folder."""
Choose = Callable[[str, Sequence[str]], str]
"""Given a question and names, returns one of them."""


@dataclass(frozen=True)
class NewRobot:
    """What a new project for a robot holds.

    Attributes:
        files: path -> text: `grip.yaml`, its first tasks, and the world of one of them.
        findings: what was found about the robot's files.
    """

    files: Mapping[str, str]
    findings: tuple[Issue, ...]


def new_robot(
    source: str, folder: Path, choose: Choose, *, by_package: bool = False, world: str | None = None
) -> NewRobot:
    """Return the files of a project.

    Args:
        source: a ready-made robot's name, a robot's file or a launch file that brings it up, the folder of a MoveIt
            configuration or description package or of a workspace with some, or such a package's name.
        folder: of the project, which `grip.yaml` begins its paths in.
        choose: asked where there are several.
        world: that it is in; None for a bench with something that one of its arms can take.
        by_package: name files of ROS packages by `package://`, since the project will be installed elsewhere.

    Raises:
        InvalidRobotError: the robot's files can't be used.
        UnknownNameError, DocumentError: there is no such robot.
    """
    said = {"ready": source} if source in ROBOTS else _chosen(source, choose)
    inspected = inspect_robot(RobotConfig(**said))
    robot = inspected.description
    if robot is None:
        raise InvalidRobotError(source, errors(inspected.findings))
    arms = arms_of(robot)
    benched = bool(robot.end_effectors) and world is None
    motions = _motions(robot, arms, BENCH if benched else SceneSnapshot())
    taking = first_grasp(_with_homes(robot, motions), _key) if benched else {}
    if benched and not taking:
        motions = _motions(robot, arms, SceneSnapshot())
    parts = _parts(robot, arms)
    lines = _robot_lines(_with_files(said, inspected), folder.resolve(), motions, by_package)
    world = world or ("bench" if taking else "table" if source in ROBOTS else "empty")
    grip = _grip_text(robot, lines, parts, inspected, world) + _bringup(Path(source).expanduser().resolve(), folder)
    files = {"grip.yaml": grip, "tasks/first.yaml": fmt(_task_text(robot, parts, motions), "first.yaml"), **taking}
    return NewRobot(files, inspected.findings)


def _motions(robot: RobotDescription, arms: Sequence[str], room: SceneSnapshot) -> dict[str, FirstMotions]:
    finder = MotionFinder(robot, room)
    return {group: finder.of(group) for group in arms}


def _with_homes(robot: RobotDescription, motions: Mapping[str, FirstMotions]) -> RobotDescription:
    """Return the robot that rests where it was found to touch nothing."""
    homes = {group: {"home": JointState.from_mapping(each.home)} for group, each in motions.items() if each.home}
    groups = {*robot.named_states, *homes}
    return replace(robot, named_states={g: {**robot.named_states.get(g, {}), **homes.get(g, {})} for g in groups})


def _chosen(source: str, choose: Choose) -> dict[str, Any]:
    """Return what `robot:` holds for a path or a package's name."""
    path = Path(source).expanduser().resolve()
    if not path.exists() and "/" not in source and not path.suffix:
        try:
            path = Packages({}, (Path.cwd() / MANIFEST,)).find(source)
        except Exception:  # noqa: BLE001 - whatever it is, the answer is the same
            raise UnknownNameError("robot", source, ROBOTS, "not a path, a package or a ready-made robot") from None
    if path.is_file() or (path / PROJECT).is_file():
        config, around = config_of(str(path), Path.cwd())
        given = config.model_dump(exclude_unset=True)
        return {k: str(around / v) if k in FILES and "://" not in v else v for k, v in given.items()}
    if not (path / MANIFEST).is_file():
        found = {str(each.relative_to(path)): each for each in configured_packages(path)}
        if not found and not Configurations(path, Packages()).alternatives():
            if "/" not in source:  # more likely a name, beside which a folder happens to lie
                raise UnknownNameError("robot", source, ROBOTS, f"{path} holds none, and none is ready-made")
            raise DocumentError("there is no MoveIt configuration package in it; name a URDF file", str(path))
        names = list(found)
        if found:
            path = found[choose(f"{source} holds several configurations", names) if len(names) > 1 else names[0]]
    every = Configurations(path, Packages({}, (path / MANIFEST,))).alternatives()
    if len(every) < 2:
        return {"moveit": str(path)}
    named = {each.name: each for each in reversed(every)}
    chosen = named[choose(f"{path.name} holds several configurations", list(reversed(named)))]
    return _named(str(path), None if chosen.arguments else chosen.srdf, {"urdf": chosen.urdf}, chosen.arguments)


def _named(moveit: str, srdf: Path | None, urdf: Mapping[str, Path | None], given: Mapping[str, Any]) -> dict[str, Any]:
    files = {key: str(file) for key, file in {**urdf, "srdf": srdf}.items() if file}
    return {"moveit": moveit, **files, **({"arguments": dict(given)} if given else {})}


def _with_files(said: Mapping[str, Any], inspected: Inspected) -> dict[str, Any]:
    """Return what `robot:` holds with the files and arguments that were found, so that nothing is searched again."""
    chosen = inspected.chosen
    if chosen is None:
        return dict(said)
    kind = "urdf" if chosen.urdf is not None and chosen.urdf.suffix == ".urdf" else "xacro"
    return _named(said["moveit"], chosen.srdf, {kind: chosen.urdf}, chosen.arguments)


def _robot_lines(
    said: Mapping[str, Any], folder: Path, motions: Mapping[str, FirstMotions], by_package: bool
) -> list[str]:
    homes = {group: dict(each.home) for group, each in motions.items() if each.home}
    if set(said) == {"ready"} and not homes:
        return [f"robot: {said['ready']}"]
    lines, states = ["robot:"], dict(said.get("states", {}))
    for key, value in said.items():
        if key in FILES and "://" not in value:
            home, path = package_around(Path(value)) if by_package else None, os.path.relpath(value, folder)
            value = f"package://{Path(name_of_package(home), os.path.relpath(value, home))}" if home else path
        if key != "states":
            lines.append(f"  {key}: {_flow(value)}")
    states |= {group: {**states.get(group, {}), "home": home} for group, home in homes.items()}
    if states:
        lines.append("  states:" + ("  # home: where nothing touches; the robot's files don't say it" if homes else ""))
        lines += [f"    {_flow(group)}: {_flow(named)}" for group, named in states.items()]
    return lines


@dataclass(frozen=True)
class _Parts:
    """Name in the project -> group, and arm -> its hand."""

    arms: Mapping[str, str]
    hands: Mapping[str, str]
    carried: Mapping[str, str]
    joined: Mapping[str, tuple[str, tuple[str, ...]]]


def _parts(robot: RobotDescription, arms: Sequence[str]) -> _Parts:
    names = {group: _key(group) for group in (*arms, *robot.hands)}
    carried = {
        names[end.parent_group]: names[end.group]
        for end in robot.end_effectors
        if end.group in robot.hands and end.parent_group in arms
    }
    joined = {}
    for group, joints in robot.groups.items():
        mine = [arm for arm in arms if set(robot.groups[arm]) <= set(joints)]
        if len(mine) > 1 and set(joints) == {joint for arm in mine for joint in robot.groups[arm]}:
            joined[_key(group)] = group, tuple(names[arm] for arm in mine)
    return _Parts({names[a]: a for a in arms}, {names[h]: h for h in robot.hands}, carried, joined)


def _key(group: str) -> str:
    word = re.sub(r"\W", "_", group)
    return word if word[:1].isalpha() else f"_{word}"


def _flow(value: object) -> str:
    """Return a value as YAML on one line."""
    text = yaml.safe_dump(value, default_flow_style=True, width=math.inf, sort_keys=False, allow_unicode=True)
    return str(text).removesuffix("...\n").rstrip()


def _grip_text(robot: RobotDescription, lines: list[str], parts: _Parts, inspected: Inspected, world: str) -> str:
    text = ["grip: 1", f"doc: A project for {robot.name}.", *lines]
    if parts.arms:
        text.append("arms:")
        for name, group in parts.arms.items():
            hand = {"hand": parts.carried[name]} if name in parts.carried else {}
            text.append(f"  {name}: {_flow({'group': group, **hand})}")
        for name, (group, arms) in parts.joined.items():
            text.append(f"  {name}: {_flow({'group': group, 'arms': arms})}")
    if parts.hands:
        text += ["hands:", *(f"  {name}: {_flow({'group': group})}" for name, group in parts.hands.items())]
    sensors = [sensor for package in inspected.packages for sensor in package.sensors if sensor.topic]
    named = {_key(sensor.name.split("/")[-1]): sensor for sensor in sensors}
    camera = "front" if world == "empty" else "overhead"
    text += ["sensors:", f"  {camera}: {{camera: {camera}}}"]
    if named:
        text.append("  # of sensors_3d.yaml; a task gives what they see to scene/add_cloud")
        for name, sensor in named.items():
            topics = {"seen": {"topic": sensor.topic, "type": sensor.message}}
            text.append(f"  {name}: {_flow({'topics': topics, 'given_in': 'world'})}")
    return "\n".join([*text, f"world: {world}", ""])


def _bringup(path: Path, folder: Path) -> str:
    """Return the process by which `grip launch` starts the real robot, where a launch file told of it."""
    if not is_launch_file(path):
        return ""
    home = package_around(path)
    where = (
        {"package": name_of_package(home), "launch": path.name} if home else {"launch": os.path.relpath(path, folder)}
    )
    return f"processes:\n  bringup: {_flow(where)}  # started by `grip launch`\n"


def _task_text(robot: RobotDescription, parts: _Parts, motions: Mapping[str, FirstMotions]) -> str:
    data: dict[str, object] = {}
    children: dict[str, object] = {}
    left: list[str] = []
    for name, group in parts.arms.items():
        todo = motions[group]
        left += [f"{state} ({' and '.join(pairs[0])} touch)" for state, pairs in todo.touching.items() if pairs]
        own = parts.carried.get(name)
        if own:
            children[f"open_{own}"] = {"node": "hand/open", "with": {"hand": own}}
        for state in todo.states:
            children[f"{name}_{_key(state)}"] = {"node": "arm/move_to", "with": {"arm": name, "state": state}}
        if todo.pose is not None:
            goal = f"{name}_goal"
            pose = {"position": todo.pose.position.tolist(), "quaternion": todo.pose.quaternion.tolist()}
            data[goal] = {"type": "Pose", "value": pose}
            to_pose = {"node": "arm/move_to_pose", "with": {"arm": name}, "in": {"pose": goal}}
            children[f"{name}_pose"] = to_pose
            children[f"{name}_again"] = to_pose
            if todo.line is not None:
                line = {"arm": name, "offset": list(todo.line)}
                children[f"{name}_line"] = {"node": "arm/move_straight", "with": line}
    for name in parts.hands:
        children[f"{name}_closed"] = {"node": "hand/posture", "with": {"hand": name, "posture": "closed"}}
        children[f"{name}_open"] = {"node": "hand/open", "with": {"hand": name}}
    for name, group in parts.arms.items():
        if motions[group].states:
            state = motions[group].states[0]
            children[f"{name}_back"] = {"node": "arm/move_to", "with": {"arm": name, "state": state}}
    if not children:
        children["done"] = {"node": "flow/log", "with": {"message": "the robot has neither an arm nor a hand"}}
    doc = f"Try {robot.name}: its named states, a pose, the same pose again, a line, and its hands."
    if left:
        doc += f" Left out, since links touch there: {'; '.join(left)}."
    task = {
        "grip": 1,
        "name": "first",
        "doc": doc,
        **({"data": data} if data else {}),
        "root": {"kind": "sequence", "children": children},
    }
    return json.dumps(task)
