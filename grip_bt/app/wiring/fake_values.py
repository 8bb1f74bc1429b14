"""A plausible value of any declared type: what fakes of sensors, topics and components give."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from grip_bt.base.errors import GripError, InvalidRobotError, MissingPartError, UnknownNameError
from grip_bt.base.failures import SensorError
from grip_bt.base.types import VALUES, Type, parse_type
from grip_bt.base.values import (
    CameraInfo,
    DepthImage,
    Failure,
    Grasp,
    Image,
    JointState,
    PathConstraint,
    Plan,
    PointCloud,
    Pose,
    RgbdFrame,
    Trajectory,
    WayPoint,
)
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.description.tree import joints_of_fingers
from grip_bt.commanders.fake import FakeArm

from ..project.folder import Project

CAMERA = CameraInfo(
    64, 48, np.array([[60.0, 0, 32], [0, 60.0, 24], [0, 0, 1]]), Pose((0.5, 0.1, 1.3), (0, 0.70710678, -0.70710678, 0))
)
"""It looks down on a table from 1.3 m."""
_AT = Pose((0.5, 0.1, 0.1), (0.5, 0.5, 0.5, 0.5))
GRASP = Grasp(_AT, _AT.moved((-0.12, 0, 0)), _AT.moved((0, 0, 0.15)), width=0.06, provenance="fake")


def empty_table() -> RgbdFrame:
    """Return what the camera sees of a table with nothing on it."""
    shape = (CAMERA.height, CAMERA.width)
    return RgbdFrame(
        Image(np.full((*shape, 3), 170, np.uint8), "fake"), DepthImage(np.full(shape, 1.3, np.float32), CAMERA)
    )


def value_of(type_: str | Type) -> Any:
    """Return a value of a type: an empty one of the builtins, something small and sensible of GRIP's.

    Args:
        type_: as manifests and sensors declare it, such as `PointCloud`, `list[Grasp]` or `std_msgs/msg/Float64`.

    Raises:
        SensorError: it is a ROS message whose package isn't there.
    """
    wanted = parse_type(type_) if isinstance(type_, str) else type_
    if wanted.optional or wanted.name in ("Any", "None"):
        return None
    if wanted.name == "list":
        return [value_of(wanted.item)] if wanted.item is not None and wanted.item.name in VALUES else []
    if wanted.name == "dict":
        return {}
    return _message(wanted.name) if "/" in wanted.name else _VALUES[wanted.name]()


def _message(name: str) -> Any:
    try:
        from grip_bt.ros.client.types import load_type

        return load_type(name)()
    except (ImportError, MissingPartError, UnknownNameError) as error:
        reason = f"there is no fake of {name}: {error}; say what the node gives: --mock NODE=SCRIPT, or --mocks FILE"
        raise SensorError(reason, type=name) from None


def _points() -> PointCloud:
    x, y = np.meshgrid(np.linspace(0.3, 0.7, 12), np.linspace(-0.2, 0.2, 12))
    return PointCloud(np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1).astype(np.float32))


def _trajectory() -> Trajectory:
    return Trajectory(("joint",), np.array([0.0, 1.0]), np.zeros((2, 1)))


_VALUES: dict[str, Callable[[], Any]] = {
    "bool": bool,
    "int": int,
    "float": float,
    "str": str,
    "bytes": bytes,
    "CameraInfo": lambda: CAMERA,
    "DepthImage": lambda: empty_table().depth,
    "Failure": lambda: Failure("fake", "nothing has failed"),
    "Grasp": lambda: GRASP,
    "Image": lambda: empty_table().image,
    "JointState": lambda: JointState(("joint",), np.zeros(1)),
    "PathConstraint": PathConstraint,
    "Plan": lambda: Plan("arm", _trajectory(), "fake"),
    "PointCloud": _points,
    "Pose": lambda: _AT,
    "RgbdFrame": empty_table,
    "Trajectory": _trajectory,
    "WayPoint": lambda: WayPoint(_AT),
}


FINGERS = ("finger", "thumb")
"""Of a hand whose robot isn't known; each is one joint, 0 when open and 1 when closed."""
_GRIPPED = 0.6
"""How far fingers close before they touch what is between them, of the way from `open` to `closed`."""


@dataclass(frozen=True)
class HandFacts:
    """What a fake hand has.

    Attributes:
        postures: its named postures, `open` and `closed` among them.
        fingers: finger -> its joints.
        thing: where something between the fingers stops them.
        forces: link -> force [N] while they press on it.
    """

    postures: Mapping[str, JointState]
    fingers: Mapping[str, tuple[str, ...]]
    thing: JointState
    forces: Mapping[str, float]


def description_of(project: Project) -> RobotDescription | None:
    """Return the project's robot, or None where there is none yet, or what describes it isn't installed.

    Raises:
        InvalidRobotError: its files are wrong.
    """
    try:
        return project.description()
    except InvalidRobotError:
        raise
    except (GripError, ImportError):
        return None  # a task can be tried before there is a robot


def arm_states(robot: RobotDescription | None, group: str) -> tuple[JointState | None, dict[str, JointState]]:
    """Return where a group's joints rest, and its named states.

    Each state but `home` is a place of the fake's own too, 5 cm above one another, since fakes know no kinematics.
    """
    if robot is None or group not in robot.groups:
        return None, {}
    joints, at_rest = robot.group(group), robot.at_rest
    own = JointState(joints, [at_rest[joint] for joint in joints])
    states, known = {}, robot.named_states.get(group, {})
    for number, name in enumerate(name for name in known if name != "home"):
        place = FakeArm(home=Pose((0.3, -0.4, 0.55 + 0.05 * number))).state()
        states[name] = JointState((*joints, *place.names), [*known[name].ordered(joints), *place.position])
    return own, states


def hand_facts(robot: RobotDescription | None, group: str) -> HandFacts:
    """Return what a fake of a hand has: its robot's own joints, fingers and postures, or two fingers of one joint."""
    known = {} if robot is None else robot.named_states.get(group, {})
    if robot is None or not {"open", "closed"} <= set(known):
        shares = dict.fromkeys(known, 0.5) | {"open": 0.0, "closed": 1.0}
        postures = {name: JointState(FINGERS, np.full(2, share)) for name, share in shares.items()}
        thing = JointState(FINGERS, np.full(2, _GRIPPED))
        return HandFacts(postures, {joint: (joint,) for joint in FINGERS}, thing, {"thumb": 2.0})

    joints, fingers = robot.group(group), joints_of_fingers(robot, group)
    begin, end = (known[name].ordered(joints) for name in ("open", "closed"))
    tips = [robot.finger_links[finger][-1] for finger in fingers]
    return HandFacts(
        known, fingers, JointState(joints, begin + _GRIPPED * (end - begin)), dict.fromkeys(tips or joints[-1:], 2.0)
    )
