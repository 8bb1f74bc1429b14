"""`grip teach`: remember where an arm or a hand is now, under a name, for the project's tasks."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from grip_bt.app.project.faults import TAUGHT
from grip_bt.app.project.folder import find_project
from grip_bt.app.wiring.open import open_resources
from grip_bt.app.wiring.parts import Opening, Resources
from grip_bt.base.errors import GripError, MissingPartError, UnknownNameError
from grip_bt.base.failures import ExpectedError
from grip_bt.base.values import JointState, Pose
from grip_bt.cli.terminal import tell
from grip_bt.commanders.taught import TaughtStates

T = TypeVar("T")


def add_teach(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("name", nargs="?", help="the name; without it, what was taught is listed")
    parser.add_argument("--project", default=".", help="a project folder, or a file in it (default: this folder)")
    part = parser.add_mutually_exclusive_group()
    part.add_argument("--arm", default="", help="which arm (default: the only one)")
    part.add_argument("--hand", help="remember a hand's posture instead")
    parser.add_argument("--pose", action="store_true", help="the pose of the arm's hand instead of its joints")
    parser.add_argument("--robot", choices=("ros", "sim"), default="ros", help="which robot to read (default: ros)")
    parser.add_argument("--json", action="store_true", help="print JSON")


def run_teach(args: argparse.Namespace) -> None:
    project = find_project(args.project)
    if args.name is None:
        return _list(project.folder / TAUGHT, args.json)
    if project.file.robot is None:
        raise MissingPartError("a robot", f"name one in {project.folder / 'grip.yaml'} (`robot:`)")
    with open_resources(Opening(project), ["arm/teach"], args.robot) as resources:
        try:
            part, value = _teach(resources, args)
        except ExpectedError as error:
            raise GripError(f"{error.code}: {error.message}") from error
        except ValueError as error:
            raise GripError(str(error)) from error
    tell(args.json, {"part": part, "name": args.name, **_plain(value)}, [_line(part, args.name, value)])


def _teach(resources: Resources, args: argparse.Namespace) -> tuple[str, JointState | Pose]:
    if args.hand is not None:
        hand = _one("hand", resources.hands, args.hand)
        return hand.name, hand.teach(args.name)
    arm = _one("arm", resources.arms, args.arm)
    return arm.name, arm.teach(args.name, pose=args.pose)


def _one(kind: str, parts: Mapping[str, T], name: str) -> T:
    if name not in parts and (name or len(parts) != 1):
        raise UnknownNameError(kind, name, parts, "grip.yaml")
    return parts[name or next(iter(parts))]


def _list(file: Path, as_json: bool) -> None:
    taught = TaughtStates(file)
    entries = [(part, name, value) for part in taught.parts() for name, value in taught.of(part).items()]
    lines = [_line(*entry) for entry in entries] or [f"nothing was taught yet; `grip teach NAME` writes {file}"]
    tell(as_json, [{"part": part, "name": name, **_plain(value)} for part, name, value in entries], lines)


def _plain(value: JointState | Pose) -> dict[str, Any]:
    if isinstance(value, JointState):
        return {"state": value.as_mapping()}
    place = {"position": value.position.tolist(), "quaternion": value.quaternion.tolist()}
    return {"pose": {**place, "frame": value.frame}}


def _line(part: str, name: str, value: JointState | Pose) -> str:
    if isinstance(value, JointState):
        return f"{part}/{name}: " + ", ".join(f"{joint} {angle:.4f}" for joint, angle in value.as_mapping().items())
    return f"{part}/{name}: {value!r}"
