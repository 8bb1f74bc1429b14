"""The real robot of a project: its controllers, wherever they run, under the same commanders as in simulation."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial

from grip_bt.app.project.faults import jerks_of_arms
from grip_bt.app.project.folder import Project
from grip_bt.app.project.needs import robot_frames
from grip_bt.app.wiring.commanders import PlannedRobot, commanded, with_move_group
from grip_bt.app.wiring.parts import Opening, Progress, Resources, report_if_slow
from grip_bt.app.wiring.ros import provide_frames
from grip_bt.base.errors import GripError, MissingPartError, UnknownNameError
from grip_bt.base.failures import SensorError
from grip_bt.base.ports import Camera, Executor, HandPort, Pausable
from grip_bt.commanders.description.tree import Tree
from grip_bt.commanders.pausing import PausableExecutor, PausableHand
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.controllers import (
    ControlledHand,
    ControllerManager,
    GripperHand,
    JointStates,
    StreamedExecutor,
    TopicExecutor,
    TopicTouch,
    TopicWrench,
    TrajectoryExecutor,
)
from grip_bt.ros.frames import mounted_frames
from grip_bt.ros.interface import RosInterface
from grip_bt.ros.interfaces.build import ensure_package
from grip_bt.ros.moveit import MoveGroupExecutor
from grip_bt.ros.sensing import RosCamera, unnamed_camera
from grip_bt.ros.transforms import Transforms
from grip_bt.task.catalog.ros_config import RosRobotConfig


def open_controllers(opening: Opening, stack: ExitStack) -> Resources:
    """Connect to the controllers that the project names under `ros`, wherever they run, and have them active.

    Raises:
        SensorError: nothing is measured of a joint.
        SwitchError: a controller can't be made active.
    """
    project, file, progress = opening.project, opening.project.file, opening.progress
    settings = file.ros
    if settings is None:
        each = ", ".join(f"{name}: {{trajectory: /CONTROLLER/follow_joint_trajectory}}" for name in file.arms)
        how = f"name the controller of each arm and hand in grip.yaml: `ros: {{controllers: {{{each}}}}}`"
        raise MissingPartError("--robot ros", how)
    # Arms that join others move by the controllers of those.
    alone = [name for name, arm in file.arms.items() if not arm.arms]
    groups = {name: file.arms[name].group for name in alone} | {n: hand.group for n, hand in file.hands.items()}
    for name in groups:
        if name not in settings.controllers:
            raise UnknownNameError("controller of", name, settings.controllers, "grip.yaml: ros/controllers")
    robot = PlannedRobot.begin(opening)
    bus = stack.enter_context(Bus("grip_robot", watched=True))
    bus.qos.update(file.qos)
    watchdog = bus.watchdog
    assert watchdog is not None, "it is open, and watched"
    planner = with_move_group(opening, robot.description, robot.process, stack, bus)
    states = JointStates(bus, settings.joint_states, settings.stale)
    joints = {n: settings.controllers[n].joints or tuple(robot.description.group(group)) for n, group in groups.items()}
    for name, names in joints.items():
        controller = settings.controllers[name]
        actions = [a for a in (controller.trajectory, controller.gripper, controller.move_group) if a is not None]
        watchdog.watch_joints(name, settings.joint_states, names, actions)
    measured = [joint for names in joints.values() for joint in names]
    _wait_for_controllers(settings, bus, states, measured, progress)
    progress("robot", f"{len(measured)} joints measured on {settings.joint_states}")
    limits, jerks = robot.description.acceleration_limits, jerks_of_arms(file.arms, robot.description)
    sliding = {name for name, joint in Tree.of(robot.description.urdf).joints.items() if joint.type == "prismatic"}
    controllers = _Controllers(settings, bus, states, limits, jerks, sliding)
    executors = {
        name: PausableExecutor(controllers.executor(name, joints[name]), limits, jerks=jerks) for name in alone
    }
    ports = {name: PausableHand(controllers.hand(name, joints[name])) for name in file.hands}
    told, stale = settings.controllers, settings.stale
    touch = {name: TopicTouch(bus, ports[name], told[name], stale) for name in file.hands}
    wrists = {n: TopicWrench(bus, topic, stale) for n in alone if (topic := told[n].wrench) is not None}
    parts = commanded(opening, robot.description, planner, executors, ports, touch=touch, wrists=wrists)
    cameras = _cameras(project, settings, bus, progress)
    robot.wait_until_ready(opening)
    watchdog.wait_ready(settings.ready)
    pausable: list[Pausable] = [*executors.values(), *ports.values()]
    return replace(parts, cameras=cameras, pausable=pausable, measure=states.fresh)


def _cameras(project: Project, settings: RosRobotConfig, bus: Bus, progress: Progress) -> dict[str, Camera]:
    """Return the cameras of sensors that say `camera`; one that isn't named under `ros` says so when it is asked."""
    sensors = [name for name, sensor in project.file.sensors.items() if sensor.camera is not None]
    for name in settings.cameras:
        if name not in sensors:
            raise UnknownNameError("sensor with a `camera`", name, sensors, "grip.yaml: ros/cameras")
    poses, _ = mounted_frames(settings.cameras)
    if any(camera.mount is None for camera in settings.cameras.values()):
        provide_frames(progress)
    ros = RosInterface(bus, Transforms(bus, robot_frames(project).with_poses(poses)))
    for name, topics in settings.cameras.items():
        progress("camera", f"{name}: {topics.image}, {topics.depth}, {topics.info}")
    return {
        name: RosCamera(name, settings.cameras[name], ros) if name in settings.cameras else unnamed_camera(name)
        for name in sensors
    }


def _wait_for_controllers(
    settings: RosRobotConfig, bus: Bus, states: JointStates, joints: Sequence[str], progress: Progress
) -> None:
    """Block until the named controllers are active and every joint is measured; what takes its time is told."""
    _provide_interfaces(settings, progress)
    most = f"waiting for it, at most {settings.ready:g} s"
    wanted = [c.name for c in settings.controllers.values() if c.name is not None]
    if wanted:
        others = [other for c in settings.controllers.values() for other in c.instead_of]
        manager = settings.controller_manager
        with report_if_slow(progress, "controllers", lambda: f"{manager} hasn't answered yet; {most}"):
            ControllerManager(bus, manager, settings.ready).ensure_active(wanted, others)
        progress("controllers", f"active: {', '.join(wanted)}")

    def missing() -> str:
        try:
            states.state(joints)
        except SensorError as error:
            return f"{error.message}; {most}"
        return f"all joints are measured on {settings.joint_states}"

    with report_if_slow(progress, "robot", missing):
        states.wait_for(joints, settings.ready)


def _provide_interfaces(settings: RosRobotConfig, progress: Progress) -> None:
    """Have the messages of controllers, built where they aren't installed: once, and that takes its time."""
    controllers = settings.controllers.values()
    needed = {
        "controller_manager_msgs": any(c.name is not None for c in controllers),
        "control_msgs": any(c.trajectory is not None or c.gripper is not None for c in controllers),
        "moveit_msgs": any(c.move_group is not None for c in controllers),
    }
    for package in (name for name, is_needed in needed.items() if is_needed):
        words = f"{package} is being built, once; up to a minute"
        with report_if_slow(progress, "interfaces", partial(str, words)):
            ensure_package(package)


@dataclass(frozen=True)
class _Controllers:
    """What the ports of a robot's parts are made with."""

    settings: RosRobotConfig
    bus: Bus
    states: JointStates
    limits: Mapping[str, float]
    jerks: Mapping[str, float]
    sliding: Collection[str]

    def executor(self, name: str, joints: Sequence[str]) -> Executor:
        """Return what moves the joints of an arm, or of a hand over a controller that follows trajectories."""
        controller, ready = self.settings.controllers[name], self.settings.ready
        if controller.trajectory is not None:
            action = controller.trajectory
            return TrajectoryExecutor(self.bus, action, joints, self.states, self.limits, self.jerks, ready)
        if controller.topic is not None:
            return TopicExecutor(self.bus, controller.topic, joints, self.states, self.limits, self.jerks)
        if controller.move_group is not None:
            return MoveGroupExecutor(self.bus, controller.move_group, joints, self.states, ready)
        if controller.positions is not None:
            return StreamedExecutor(self.bus, controller.positions, joints, self.states, self.limits, self.jerks)
        ways = "`trajectory`, `topic`, `positions` or `move_group`"
        raise GripError(f"grip.yaml: ros/controllers/{name}: an arm isn't a gripper; say {ways}")

    def hand(self, name: str, joints: Sequence[str]) -> HandPort:
        """Return what moves the joints of a hand."""
        gripper = self.settings.controllers[name].gripper
        if gripper is None:
            return ControlledHand(self.executor(name, joints), self.limits, self.sliding)
        if len(joints) != 1:
            reason = f"a gripper is commanded through one joint, not {len(joints)}; name it: `joints: [NAME]`"
            raise GripError(f"grip.yaml: ros/controllers/{name}: {reason}")
        return GripperHand(self.bus, gripper, joints[0], self.states, self.settings.ready)
