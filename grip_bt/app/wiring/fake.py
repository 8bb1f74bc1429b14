"""Parts that do as asked, at once, without a robot, and a plausible value of any type: for trying a task."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from typing import Any

import numpy as np

from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.app.project.folder import Project
from grip_bt.app.project.needs import robot_frames
from grip_bt.app.wiring.parts import FakeState, Opening, Resources
from grip_bt.base.errors import GripError, InvalidRobotError, MissingPartError, UnknownNameError
from grip_bt.base.failures import ExpectedError, SensorError
from grip_bt.base.message_store import STANDARD, Entry, LocalMessages
from grip_bt.base.operation import Operation
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
from grip_bt.base.values.joints import Span
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.description.tree import joints_of_fingers
from grip_bt.commanders.fake import FakeArm, FakeCamera, FakeComponent, FakeHand, FakeRos, FakeSensor
from grip_bt.commanders.hand import HandCommander
from grip_bt.commanders.scene import PlanningScene
from grip_bt.commanders.taught import TaughtStates
from grip_bt.ros.frames import FrameError, mounted_frames
from grip_bt.task.catalog.component_file import load_component
from grip_bt.task.catalog.manifest import Manifest
from grip_bt.task.catalog.ros_config import SensorConfig

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


def value_of(type_: str | Type) -> object:
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


_VALUES: dict[str, Callable[[], object]] = {
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


def _arm(name: str, robot: RobotDescription | None, group: str, taught: TaughtStates) -> FakeArm:
    """Return a fake arm whose joints rest, and whose states are, as the robot's files say.

    Each state but `home` is a place of the fake's own too, 5 cm above one another, since fakes know no kinematics.
    """
    if robot is None or group not in robot.groups:
        return FakeArm(name, states={}, taught=taught, own=None)
    joints, at_rest = robot.group(group), robot.at_rest
    own = JointState(joints, [at_rest.get(joint, 0.0) for joint in joints])
    states, known = {}, robot.named_states.get(group, {})
    for number, state in enumerate(state for state in known if state != "home"):
        place = FakeArm(home=Pose((0.3, -0.4, 0.55 + 0.05 * number))).state()
        states[state] = JointState((*joints, *place.names), [*known[state].ordered(joints), *place.position])
    return FakeArm(name, states=states, taught=taught, own=own)


def _hand(
    name: str, robot: RobotDescription | None, group: str, taught: TaughtStates
) -> tuple[FakeHand, HandCommander]:
    """Return a fake hand with its robot's own joints, fingers and postures, or with two fingers of one joint."""
    postures = {} if robot is None else robot.named_states.get(group, {})
    joints: tuple[str, ...] = FINGERS
    fingers: Mapping[str, tuple[str, ...]] = {joint: (joint,) for joint in FINGERS}
    tips = ["thumb"]
    if robot is None or not {"open", "closed"} <= set(postures):
        shares = dict.fromkeys(postures, 0.5) | {"open": 0.0, "closed": 1.0}
        postures = {posture: JointState(FINGERS, np.full(2, share)) for posture, share in shares.items()}
    else:
        joints, fingers = robot.group(group), joints_of_fingers(robot, group)
        tips = [robot.finger_links[finger][-1] for finger in fingers] or list(joints[-1:])
    begin, end = (postures[posture].ordered(joints) for posture in ("open", "closed"))
    thing = JointState(joints, begin + _GRIPPED * (end - begin))
    port = FakeHand(postures["open"], thing=thing, forces=dict.fromkeys(tips, 2.0), closed=postures["closed"])
    commander = HandCommander(
        name,
        port,
        postures,
        fingers=fingers,
        taught=taught,
        reach=lambda targets, posture, frame: posture,  # a fake has no geometry: it is there already
        spans=_spans,
        touch=port,
    )
    return port, commander


def _spans(postures: Sequence[JointState]) -> list[Span]:
    """Return what would be between the fingers of a parallel gripper of common size."""
    gaps, corners = np.linspace(0.1, 0.0, len(postures)), np.array([[0.03, 0.08, 0.01], [-0.03, -0.08, -0.12]])
    return [
        Span(p, gap, np.zeros(3), np.array([0.0, 1.0, 0.0]), 0.05, corners, p)
        for p, gap in zip(postures, gaps, strict=True)
    ]


def open_fakes(opening: Opening, stack: ExitStack) -> Resources:
    """Make a fake of every arm, hand and camera of the project; there is nothing to start."""
    project, file = opening.project, opening.project.file
    robot, taught = description_of(project), TaughtStates()
    arms = {name: _arm(name, robot, arm.group, taught) for name, arm in file.arms.items()}
    hands = {name: _hand(name, robot, hand.group, taught) for name, hand in file.hands.items()}
    carried = {arm.hand: arms[name].grasp_pose for name, arm in file.arms.items() if arm.hand is not None}
    palms = dict.fromkeys(file.hands, Pose) | carried  # a hand alone stays where it is
    return Resources(
        arms=arms,
        hands={name: commander for name, (_, commander) in hands.items()},
        cameras={name: FakeCamera(CAMERA, [empty_table()]) for name, s in file.sensors.items() if s.camera},
        scene=PlanningScene(palms, _CRATE, project.room(), folder=project.folder),
        fakes=FakeState(arms, {name: port for name, (port, _) in hands.items()}, taught=taught),
    )


def fake_components(project: Project, names: list[str]) -> dict[str, FakeComponent]:
    """Return fakes of components: their replies go through their outcomes, in order.

    Raises:
        UnknownNameError: a component isn't in the project.
    """
    folders = project.component_folders()
    for name in names:
        if name not in folders:
            raise UnknownNameError("component", name, folders, str(project.folder))
    files = {name: load_component(folders[name]) for name in names}
    catalog = catalogue_of(project)
    return {
        name: FakeComponent(_replies(catalog.get(f"component/{name}"), len(file.outcomes)))
        for name, file in files.items()
    }


def fake_ros(project: Project, sensors: Iterable[str]) -> tuple[FakeRos, dict[str, FakeSensor]]:
    """Return a fake of ROS itself, and of sensors on topics: they give values of the declared types.

    What has no fake, a message whose package isn't there, is said when it is asked for. Frames are those of the robot
    that never move and of the sensors' mounts; every other one is where the frame is that it is looked up in.
    """
    heard = lambda type_: type_ == "bool" or value_of(type_)  # noqa: E731 - a signal says yes, as fakes do
    return FakeRos(heard, _frames(project)), {n: FakeSensor([_moment(project.file.sensors[n])]) for n in sensors}


class FakeMessages(LocalMessages):
    """A project's named messages; what an empty store is asked for, where its type is known, is a plausible value.

    Args:
        arms: where the first is stands for an unknown joint state.
        tell: told of each value that was made up.
    """

    def __init__(self, local: LocalMessages, arms: Iterable[FakeArm], tell: Callable[[str, str], None]):
        super().__init__(local.library, local.saved)
        self._arm, self._tell = next(iter(arms), None), tell

    def get(self, store: str, name: str) -> Operation[Entry[object]]:
        """Return an entry, or what stands for it."""
        try:
            return Operation.finished(super().get(store, name).result())
        except ExpectedError as error:
            if store not in STANDARD or len(self.library.store(store)):
                return Operation.failed(error)
        at = self._arm.state() if store == "joint_states" and self._arm is not None else None
        value = value_of(STANDARD[store]) if at is None else at
        self._tell("messages", f"{store} is empty: a fake {name or 'value'}")
        return Operation.finished(Entry(name, value, time.time(), "fake"))


def _moment(sensor: SensorConfig) -> dict[str, object] | ExpectedError:
    try:
        return {port: value_of(topic.type) for port, topic in sensor.topics.items()}
    except ExpectedError as error:
        return error


def _frames(project: Project) -> Callable[[str, str], Pose]:
    poses, _ = mounted_frames(project.file.sensors)
    tree = robot_frames(project).with_poses(poses)

    def pose(target: str, source: str) -> Pose:
        try:
            return tree.lookup(target, source)
        except FrameError:
            return Pose(frame=target)

    return pose


def _replies(manifest: Manifest, outcomes: int) -> list[dict[str, object]]:
    """Return a reply with each outcome in turn; its fields are of the types that the node declares."""
    fields = {port: value_of(face.type) for port, face in manifest.outputs.items()}
    fields = {port: {} if value is None else value for port, value in fields.items()}
    fields.setdefault("returned_object", [GRASP])
    return [{**fields, "outcome": number} for number in range(outcomes)]


_CRATE: dict[str, Any] = {
    f"crate_{side}": (size, Pose((0.48 + dx, -0.40 + dy, 0.03)))
    for side, size, dx, dy in (
        ("left", (0.28, 0.01, 0.06), 0.0, 0.155),
        ("right", (0.28, 0.01, 0.06), 0.0, -0.155),
        ("far", (0.01, 0.30, 0.06), 0.135, 0.0),
        ("near", (0.01, 0.30, 0.06), -0.135, 0.0),
    )
}
