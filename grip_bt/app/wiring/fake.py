"""Parts that do as asked, at once, without a robot: for drawing and trying a task before there is one."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import ExpectedError
from grip_bt.base.values import Pose
from grip_bt.commanders.fake import FakeArm, FakeCamera, FakeComponent, FakeHand, FakeRos, FakeSensor
from grip_bt.commanders.hand import HandCommander
from grip_bt.commanders.scene import PlanningScene
from grip_bt.commanders.taught import Taught
from grip_bt.task.catalog.component_file import load_component
from grip_bt.task.catalog.manifest import Manifest
from grip_bt.task.catalog.sensors import SensorConfig

from ..project.folder import Project
from ..project.frames import robot_frames
from .fake_values import CAMERA, GRASP, HandFacts, arm_states, description_of, empty_table, hand_facts, value_of
from .parts import Resources

if TYPE_CHECKING:
    from grip_bt.commanders.description.robot import RobotDescription


def open_robot(project: Project, resources: Resources) -> None:
    """Put a fake of every arm, hand and camera of the project into `resources`."""
    file = project.file
    robot = description_of(project)
    fakes = resources.fakes = resources.fakes or FakeState()
    taught = fakes.taught
    arms = {name: _arm(name, robot, arm.group, taught) for name, arm in file.arms.items()}
    hands = {arm.hand: arms[name] for name, arm in file.arms.items() if arm.hand is not None}
    resources.arms, resources.pausable = arms, list(arms.values())
    facts = {name: hand_facts(robot, hand.group) for name, hand in file.hands.items()}
    ports = {name: _fingers(each) for name, each in facts.items()}
    resources.hands = {name: _hand(name, ports[name], taught, facts[name]) for name in file.hands}
    fakes.arms, fakes.hands = arms, ports
    resources.cameras = {name: FakeCamera(CAMERA, [empty_table()]) for name, s in file.sensors.items() if s.camera}
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
    catalog = catalogue_of(project)
    components = {
        name: FakeComponent(_replies(catalog.get(f"component/{name}"), len(file.outcomes)))
        for name, file in files.items()
    }
    resources.components = components
    fakes = resources.fakes = resources.fakes or FakeState()
    fakes.components = components


def open_ros(project: Project, sensors: Iterable[str], resources: Resources) -> None:
    """Put fakes of sensors on topics, and of ROS itself, into `resources`: they give values of the declared types.

    What has no fake, a message whose package isn't there, is said when it is asked for. Frames are those of the robot
    that never move and of the sensors' mounts; every other one is where the frame is that it is looked up in.
    """
    resources.ros = FakeRos(value_of, _frames(project))
    resources.sensors = {name: FakeSensor([_moment(project.file.sensors[name])]) for name in sensors}


def _moment(sensor: SensorConfig) -> dict[str, Any] | ExpectedError:
    try:
        return {port: value_of(topic.type) for port, topic in sensor.topics.items()}
    except ExpectedError as error:
        return error


def _frames(project: Project) -> Callable[[str, str], Pose]:
    from grip_bt.ros.frames import FrameError, mounted_frames

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


def _arm(name: str, robot: RobotDescription | None, group: str, taught: Taught) -> FakeArm:
    own, states = arm_states(robot, group)
    return FakeArm(name, states=states, taught=taught, own=own)


def _fingers(facts: HandFacts) -> FakeHand:
    opened, closed = facts.postures["open"], facts.postures["closed"]
    return FakeHand(opened, thing=facts.thing, forces=facts.forces, closed=closed)


def _hand(name: str, port: FakeHand, taught: Taught, facts: HandFacts) -> HandCommander:
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


@dataclass
class FakeState:
    """Where fake arms and hands are, what was taught to them, and which reply of a component is the next.

    Attributes:
        arms: by name.
        hands: by name.
        components: by name.
        taught: what was taught to arms and hands.
    """

    arms: Mapping[str, FakeArm] = field(default_factory=dict)
    hands: Mapping[str, FakeHand] = field(default_factory=dict)
    components: Mapping[str, FakeComponent] = field(default_factory=dict)
    taught: Taught = field(default_factory=Taught)

    def kept(self) -> dict[str, Any]:
        """Return all of it, as a value of the journal."""
        return {
            "arms": {name: arm.state().position for name, arm in self.arms.items()},
            "hands": {name: hand.kept() for name, hand in self.hands.items()},
            "components": {name: component.given for name, component in self.components.items()},
            "taught": {part: dict(self.taught.of(part)) for part in self.taught.parts()},
        }

    def put_back(self, kept: Mapping[str, Any]) -> None:
        """Have everything as it was; nothing may be under way.

        Raises:
            KeyError, ValueError: an arm, a hand or a component isn't here any more, or has other joints.
        """
        for parts, states in ((self.arms, kept["arms"]), (self.hands, kept["hands"])):
            for name, position in states.items():
                parts[name].put_back(position)
        for name, given in kept["components"].items():
            self.components[name].put_back(given)
        for part, entries in kept["taught"].items():
            for name, value in entries.items():
                self.taught.put(part, name, value, {})
