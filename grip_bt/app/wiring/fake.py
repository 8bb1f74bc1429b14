"""Parts that do as asked, at once, without a robot: for drawing and trying a task before there is one."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import ExitStack
from typing import Any

from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.app.project.needs import robot_frames
from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import ExpectedError
from grip_bt.base.values import Pose
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.fake import FakeArm, FakeCamera, FakeComponent, FakeHand, FakeRos, FakeSensor
from grip_bt.commanders.hand import HandCommander
from grip_bt.commanders.scene import PlanningScene
from grip_bt.commanders.taught import TaughtStates
from grip_bt.ros.frames import FrameError, mounted_frames
from grip_bt.task.catalog.component_file import load_component
from grip_bt.task.catalog.manifest import Manifest
from grip_bt.task.catalog.ros_config import SensorConfig

from ..project.folder import Project
from .fake_values import CAMERA, GRASP, HandFacts, arm_states, description_of, empty_table, hand_facts, value_of
from .parts import FakeState, Opening, Resources


class FakeBackend:
    """Implements `RobotBackend`: a fake of every arm, hand and camera of the project."""

    def open(self, opening: Opening, stack: ExitStack) -> Resources:
        """Make them; there is nothing to start."""
        project, file = opening.project, opening.project.file
        robot, taught = description_of(project), TaughtStates()
        arms = {name: _arm(name, robot, arm.group, taught) for name, arm in file.arms.items()}
        facts = {name: hand_facts(robot, hand.group) for name, hand in file.hands.items()}
        ports = {
            name: FakeHand(each.postures["open"], thing=each.thing, forces=each.forces, closed=each.postures["closed"])
            for name, each in facts.items()
        }
        palms = {arm.hand: arms[name].grasp_pose for name, arm in file.arms.items() if arm.hand is not None}
        return Resources(
            arms=arms,
            hands={name: _hand(name, ports[name], taught, facts[name]) for name in file.hands},
            cameras={name: FakeCamera(CAMERA, [empty_table()]) for name, s in file.sensors.items() if s.camera},
            scene=PlanningScene(palms, _CRATE, project.room(), folder=project.folder),
            pausable=tuple(arms.values()),
            fakes=FakeState(arms, ports, taught=taught),
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
    return FakeRos(value_of, _frames(project)), {n: FakeSensor([_moment(project.file.sensors[n])]) for n in sensors}


def _moment(sensor: SensorConfig) -> dict[str, Any] | ExpectedError:
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


def _replies(manifest: Manifest, outcomes: int) -> list[dict[str, Any]]:
    """Return a reply with each outcome in turn; its fields are of the types that the node declares."""
    fields = {port: value_of(face.type) for port, face in manifest.outputs.items()}
    fields = {port: {} if value is None else value for port, value in fields.items()}
    fields.setdefault("returned_object", [GRASP])
    return [{**fields, "outcome": number} for number in range(outcomes)]


def _arm(name: str, robot: RobotDescription | None, group: str, taught: TaughtStates) -> FakeArm:
    own, states = arm_states(robot, group)
    return FakeArm(name, states=states, taught=taught, own=own)


def _hand(name: str, port: FakeHand, taught: TaughtStates, facts: HandFacts) -> HandCommander:
    return HandCommander(
        name,
        port,
        facts.postures,
        fingers=facts.fingers,
        taught=taught,
        reach=lambda targets, posture, frame: posture,  # a fake has no geometry: it is there already
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
