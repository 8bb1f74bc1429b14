"""`grip robot`: what is wrong with a robot's files, what a robot has, and which robots are ready-made."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from grip_bt.base.errors import GripError
from grip_bt.base.issue import Issue
from grip_bt.cli.parser import add_actions
from grip_bt.cli.terminal import counted, tell
from grip_bt.commanders.description.files import robot_issue
from grip_bt.commanders.description.from_files import Inspected
from grip_bt.commanders.description.moveit_package import MoveItPackage
from grip_bt.commanders.description.packages import ROBOTS
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.description.tree import Tree
from grip_bt.commanders.settings import PLANNERS, SOLVERS

WHAT = (
    "a ready-made robot, a .urdf, .xacro or .xml (MJCF) file, a .yaml file with what `robot:` may hold, a MoveIt "
    "configuration package's folder, or a project's folder"
)


def add_robot(parser: argparse.ArgumentParser) -> None:
    check, show, listed = add_actions(
        parser,
        {
            "check": (_run_check, "everything that is wrong with robots' files; exit status 1 for errors"),
            "show": (_run_show, "groups, joints, limits, end effectors, states, solvers, planners"),
            "list": (lambda args: tell(args.json, list(ROBOTS), ROBOTS), "the ready-made robots"),
        },
    )
    for each in (check, show):
        each.add_argument("robot", metavar="FILE|NAME|FOLDER", help=WHAT)
        each.add_argument("--srdf", metavar="FILE", help="the SRDF of a URDF or xacro file")
        listing = partial(each.add_argument, action="append", default=[])
        listing("--arg", metavar="NAME=VALUE", help="an argument of a xacro file")
        listing("--package", metavar="NAME=FOLDER", help="where a package lies, for package://")
        each.add_argument("--json", action="store_true", help="print one JSON object")
    listed.add_argument("--json", action="store_true", help="print one JSON list")


def _run_check(args: argparse.Namespace) -> int:
    inspected = _inspected(args)
    findings = [*inspected.findings, *_of_model(inspected)]
    wrong = sum(finding.severity == "error" for finding in findings)
    lines = [*map(str, findings), f"{args.robot}: {counted(wrong, len(findings) - wrong)}"]
    tell(args.json, {"robot": args.robot, "findings": [f.as_dict() for f in findings]}, lines)
    return int(wrong > 0)


def _run_show(args: argparse.Namespace) -> int:
    inspected = _inspected(args)
    if inspected.description is None:
        for finding in inspected.findings:
            print(finding, file=sys.stderr)
        return 1
    tell(args.json, _facts(inspected.description, inspected.packages))
    return 0


def _inspected(args: argparse.Namespace) -> Inspected:
    """Return the robot; whatever keeps it from being read is a finding too."""
    from grip_bt.commanders.description.load import config_of, inspect_robot  # `robot list` needs no extra

    more = {
        "srdf": str(Path(args.srdf).resolve()) if args.srdf else None,
        "arguments": _pairs(args, "arg"),
        "packages": {name: str(Path(folder).resolve()) for name, folder in _pairs(args, "package").items()},
    }
    given = {key: value for key, value in more.items() if value}
    if not given:
        return inspect_robot(args.robot)
    if args.robot in ROBOTS:
        args.usage_error(f"{args.robot} is ready-made and takes no {', '.join(given)}; ./{args.robot} is a folder")
    config, folder = config_of(args.robot, Path.cwd())
    return inspect_robot(config.model_copy(update=given), folder)


def _of_model(inspected: Inspected) -> list[Issue]:
    """Return what only shows when the kinematics and the shapes are made, such as a mesh that can't be read."""
    if inspected.description is None:
        return []
    from grip_bt.commanders.kinematics.model import RobotModel

    try:
        RobotModel(inspected.description)
    except (GripError, ValueError, RuntimeError) as error:
        return [robot_issue("error", "bad-model", " ".join(str(error).split()))]
    return []


def _pairs(args: argparse.Namespace, option: str) -> dict[str, str]:
    pairs = {}
    for word in getattr(args, option):
        name, equals, value = word.partition("=")
        if not equals or not name:
            args.usage_error(f"--{option} takes NAME=VALUE, not {word!r}")
        pairs[name] = value
    return pairs


def _facts(robot: RobotDescription, packages: Sequence[MoveItPackage]) -> dict[str, Any]:
    """Return a robot's groups, joints, limits, end effectors, states, and what can plan for it, as JSON data."""
    joints = Tree.of(robot.urdf).joints
    return {
        "name": robot.name,
        "base_link": robot.base_link,
        "groups": dict(robot.groups),
        "joints": {
            name: {
                **{key: getattr(joint, key) for key in ("type", "lower", "upper", "velocity", "effort")},
                "acceleration": robot.acceleration_limits[name],
                "follows": robot.mimics[name].joint if name in robot.mimics else None,
            }
            for name, joint in joints.items()
            if joint.movable
        },
        "hands": dict(robot.hands),
        "fingers": dict(robot.finger_links),
        "end_effectors": [asdict(end) for end in robot.end_effectors],
        "grasp_frames": {group: frame.link for group, frame in robot.grasp_frames.items()}
        or {"": robot.grasp_frame.link},
        "states": {
            group: {name: state.as_mapping() for name, state in states.items()}
            for group, states in robot.named_states.items()
        },
        "solvers": sorted(SOLVERS),
        "planners": sorted(PLANNERS),
        "preferences": {
            group: {field: asdict(preference) for field, preference in fields.items()}
            for group, fields in robot.preferences.items()
        },
        "moveit": [asdict(package) | {"folder": str(package.folder)} for package in packages],
    }
