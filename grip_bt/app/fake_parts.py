"""Parts that do as asked, at once, without a robot: for drawing and trying a task before there is one."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from grip_bt.catalog.component_file import load_component
from grip_bt.catalog.manifest import Manifest
from grip_bt.catalog.types import parse_type
from grip_bt.commanders.fake import FakeArm, FakeCamera, FakeComponent, FakeHand
from grip_bt.commanders.hand import HandCommander
from grip_bt.commanders.scene import PlanningScene
from grip_bt.errors import GripError, InvalidRobotError, UnknownNameError
from grip_bt.values import CameraInfo, DepthImage, Grasp, Image, JointState, Pose, RgbdFrame

from .project import Project
from .resources import Resources


def open_robot(project: Project, resources: Resources) -> None:
    """Put a fake of every arm, hand and camera of the project into `resources`."""
    file = project.file
    known = _state_names(project)
    arms = {name: FakeArm(name, states=_arm_states(known.get(arm.group, ()))) for name, arm in file.arms.items()}
    hands = {arm.hand: arms[name] for name, arm in file.arms.items() if arm.hand is not None}
    resources.arms, resources.pausable = arms, list(arms.values())
    resources.hands = {name: _hand(name, known.get(hand.group, ())) for name, hand in file.hands.items()}
    resources.cameras = {name: FakeCamera(_CAMERA, [_empty_table()]) for name, s in file.sensors.items() if s.camera}
    resources.scene = PlanningScene(
        {hand: arm.grasp_pose for hand, arm in hands.items()}, _CRATE, project.room(), folder=project.folder
    )


def open_components(project: Project, names: list[str], resources: Resources) -> None:
    """Put fakes of components into `resources`: their replies go through their outcomes, in order.

    Raises:
        UnknownNameError: a component isn't in the project.
    """
    folders = project.component_folders()
    for name in names:
        if name not in folders:
            raise UnknownNameError("component", name, folders, str(project.folder))
    files = {name: load_component(folders[name]) for name in names}
    catalog = project.catalog()
    resources.components = {
        name: FakeComponent(
            [
                {**_nothing(catalog.get(f"component/{name}")), "outcome": number, "returned_object": [_GRASP]}
                for number in range(len(file.outcomes))
            ]
        )
        for name, file in files.items()
    }


def _nothing(manifest: Manifest) -> dict[str, Any]:
    """Return an empty value for each output, so that outcomes by rule can be told."""
    empty: dict[str, Any] = {"bool": False, "int": 0, "float": 0.0, "str": "", "list": [], "dict": {}}
    return {port: empty.get(parse_type(face.type).name) for port, face in manifest.outputs.items()}


def _state_names(project: Project) -> dict[str, tuple[str, ...]]:
    """Return group -> names of its states, as far as the robot's description can be had here.

    Raises:
        InvalidRobotError: its files are wrong.
    """
    try:
        return {group: tuple(states) for group, states in project.description().named_states.items()}
    except InvalidRobotError:
        raise
    except (GripError, ImportError):
        return {}  # a task can be tried before there is a robot, or what describes it


def _arm_states(names: Iterable[str]) -> dict[str, JointState]:
    """Return a place of its own for each state but `home`, 5 cm above one another: fakes know no kinematics."""
    states = {}
    for number, name in enumerate(name for name in names if name != "home"):
        states[name] = FakeArm(home=Pose((0.3, -0.4, 0.55 + 0.05 * number))).state()
    return states


def _hand(name: str, known: Iterable[str] = ()) -> HandCommander:
    joints = ("finger", "thumb")
    postures = {posture: JointState(joints, np.full(2, angle)) for posture, angle in (("open", 0.0), ("closed", 1.0))}
    for posture in known:
        postures.setdefault(posture, JointState(joints, np.full(2, 0.5)))
    thing = JointState(joints, np.full(2, 0.6))
    return HandCommander(
        name,
        FakeHand(postures["open"], thing=thing, forces={"thumb": 2.0}),
        postures,
        fingers={j: (j,) for j in joints},
    )


_CAMERA = CameraInfo(
    64, 48, np.array([[60.0, 0, 32], [0, 60.0, 24], [0, 0, 1]]), Pose((0.5, 0.1, 1.3), (0, 0.70710678, -0.70710678, 0))
)
_CRATE: dict[str, Any] = {
    f"crate_{side}": (size, Pose((0.48 + dx, -0.40 + dy, 0.03)))
    for side, size, dx, dy in (
        ("left", (0.28, 0.01, 0.06), 0.0, 0.155),
        ("right", (0.28, 0.01, 0.06), 0.0, -0.155),
        ("far", (0.01, 0.30, 0.06), 0.135, 0.0),
        ("near", (0.01, 0.30, 0.06), -0.135, 0.0),
    )
}
_AT = Pose((0.5, 0.1, 0.1), (0.5, 0.5, 0.5, 0.5))
_GRASP = Grasp(_AT, _AT.moved((-0.12, 0, 0)), _AT.moved((0, 0, 0.15)), width=0.06, provenance="fake")


def _empty_table() -> RgbdFrame:
    shape = (_CAMERA.height, _CAMERA.width)
    return RgbdFrame(
        Image(np.full((*shape, 3), 170, np.uint8), "fake"), DepthImage(np.full(shape, 1.3, np.float32), _CAMERA)
    )
