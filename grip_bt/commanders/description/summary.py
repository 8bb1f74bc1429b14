"""What `grip robot show` tells about a robot, as JSON data and as text."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from grip_bt.base.types import Value
from grip_bt.commanders.settings import PLANNERS, SOLVERS

from .moveit_package import MoveItPackage
from .robot import RobotDescription
from .tree import Joint, Tree


def facts(robot: RobotDescription, packages: Sequence[MoveItPackage] = ()) -> dict[str, object]:
    """Return a robot's groups, joints, limits, end effectors, states, and what can plan for it, as JSON data."""
    joints = Tree(ET.fromstring(robot.urdf)).joints
    return {
        "name": robot.name,
        "base_link": robot.base_link,
        "groups": {group: list(mine) for group, mine in robot.groups.items()},
        "joints": {
            name: {
                "type": joints[name].type,
                "lower": joints[name].lower,
                "upper": joints[name].upper,
                "velocity": joints[name].velocity,
                "effort": joints[name].effort,
                "acceleration": robot.acceleration_limits[name],
                "follows": robot.mimics[name].joint if name in robot.mimics else None,
            }
            for name in joints
            if joints[name].movable
        },
        "hands": {hand: list(links) for hand, links in robot.hands.items()},
        "fingers": {finger: list(links) for finger, links in robot.finger_links.items()},
        "end_effectors": [asdict(end) for end in robot.end_effectors],
        "grasp_frames": {group: frame.link for group, frame in robot.grasp_frames.items()}
        or {"": robot.grasp_frame.link},
        "states": {
            group: {name: state.as_mapping() for name, state in states.items()}
            for group, states in robot.named_states.items()
        },
        "solvers": sorted(name for name in SOLVERS if name != "analytic" or _has_six_turning(robot, joints)),
        "planners": sorted(PLANNERS),
        "preferences": {
            group: {field: asdict(preference) for field, preference in fields.items()}
            for group, fields in robot.preferences.items()
        },
        "moveit": [_package(package) for package in packages],
    }


def _has_six_turning(robot: RobotDescription, joints: Mapping[str, Joint]) -> bool:
    """Tell whether a group may be an arm for the analytic solver, which then looks at its axes."""
    kinds = [[joints[name].type for name in mine] for mine in robot.groups.values()]
    return any(len(mine) == 6 and set(mine) <= {"revolute", "continuous"} for mine in kinds)


def _package(package: MoveItPackage) -> dict[str, object]:
    return {
        "folder": str(package.folder),
        "layout": package.layout,
        "limits": {
            joint: {name: value for name, value in asdict(limits).items() if value is not None}
            for joint, limits in package.limits.items()
        },
        "initial_positions": dict(package.initial_positions),
        "kinematics": dict(package.kinematics),
        "planners": {g: {"default": c.default, "planners": dict(c.planners)} for g, c in package.planners.items()},
        "controllers": [asdict(controller) for controller in package.controllers],
        "sensors": [asdict(sensor) for sensor in package.sensors],
    }


def told(known: Mapping[str, object]) -> str:
    """Return facts as text for people."""
    return "\n".join(_lines(dict(known)))


def _lines(known: dict[str, Value]) -> Iterator[str]:
    yield f"{known['name']}, standing on {known['base_link']}"
    for group, joints in known["groups"].items():
        frame = known["grasp_frames"].get(group)
        plural = "" if len(joints) == 1 else "s"
        yield f"\ngroup {group}: {len(joints)} joint{plural}{', grasp frame on ' + frame if frame else ''}"
        yield from (_joint(name, known["joints"][name]) for name in joints)
        for name, state in known["states"].get(group, {}).items():
            yield f"  state {name}: {', '.join(f'{q:g}' for q in state.values())}"
    followers = {name: joint["follows"] for name, joint in known["joints"].items() if joint["follows"]}
    grouped = {joint for joints in known["groups"].values() for joint in joints}
    loose = [name for name in known["joints"] if name not in grouped and name not in followers]
    yield ""
    for end in known["end_effectors"]:
        yield f"end effector {end['name']}: {end['group'] or 'a tool'} on {end['parent_link']} of {end['parent_group']}"
    for finger, links in known["fingers"].items():
        yield f"finger {finger}: {', '.join(links)}"
    for name, leader in followers.items():
        yield f"joint {name} follows {leader}"
    for name in loose:
        yield f"joint {name} belongs to no group"
    yield f"solvers: {', '.join(known['solvers'])}"
    yield f"planners: {', '.join(known['planners'])}"
    for group, fields in known["preferences"].items():
        words = [_preferred(field, preference) for field, preference in fields.items()]
        yield f"in force for {group}, unless grip.yaml says otherwise: {'; '.join(words)}"
    for package in known["moveit"]:
        yield from _moveit(package, set(known["planners"]))


def _joint(name: str, joint: dict[str, Any]) -> str:
    unit = "m" if joint["type"] == "prismatic" else "rad"
    return (
        f"  {name}: {joint['lower']:.4g} ... {joint['upper']:.4g} {unit}, {joint['velocity']:.4g} {unit}/s, "
        f"{joint['acceleration']:.4g} {unit}/s^2"
    )


def _preferred(field: str, preference: dict[str, Any]) -> str:
    source = preference["source"]
    if preference["value"] is None:
        return f"{field} as usual ({source} asks for {preference['unknown']}, which isn't here)"
    parameters = preference["parameters"].get(preference["value"], {})
    words = "".join(f", {name} {value:g}" for name, value in parameters.items())
    return f"{field} {preference['value']}{words} (from {source})"


def _moveit(package: dict[str, Any], planners: set[str]) -> Iterator[str]:
    yield f"\nMoveIt configuration ({package['layout']}): {package['folder']}"
    for joint, limits in package["limits"].items():
        said = ", ".join(f"{name} {value:g}" for name, value in limits.items())
        yield f"  limits of {joint}, in place of the URDF's: {said or 'none'}"
    if package["initial_positions"]:
        at = ", ".join(f"{joint} {position:g}" for joint, position in package["initial_positions"].items())
        yield f"  at rest: {at} (initial_positions.yaml)"
    for group, plugin in package["kinematics"].items():
        yield f"  kinematics of {group}: {plugin}"
    for group, choice in package["planners"].items():
        names = [name if name in planners else f"{name} (not here)" for name in choice["planners"].values()]
        default = f", by default {choice['default']}" if choice["default"] else ""
        yield f"  planners of {group}: {', '.join(names)}{default}"
    for controller in package["controllers"]:
        yield f"  controller {controller['name']} ({controller['type']}): {', '.join(controller['joints'])}"
    for sensor in package["sensors"]:
        yield f"  sensor {sensor['name']}: {sensor['plugin']} on {sensor['topic']}"
