"""What a run has of ROS: components, sensors on topics, frames, and the connection itself."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from contextlib import ExitStack
from functools import partial

from grip_bt.app.project.folder import ArmConfig, Project
from grip_bt.app.project.needs import robot_frames
from grip_bt.app.wiring.parts import Opening, Progress, Resources
from grip_bt.base.errors import GripError
from grip_bt.base.failures import ServerLostError
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.client.connection import TreeNode as TreeNode
from grip_bt.ros.components import Components, start_components
from grip_bt.ros.environment import free_domain, own_domain
from grip_bt.ros.frames import mounted_frames
from grip_bt.ros.interface import RosClock, RosInterface
from grip_bt.ros.interfaces.build import ensure_package
from grip_bt.ros.messages.service import RosMessages
from grip_bt.ros.moveit import ArmMapping, MoveGroup, MoveGroupPlanner
from grip_bt.ros.sensing import TopicSensor, close_sensors, open_sensors
from grip_bt.ros.transforms import Transforms
from grip_bt.task.catalog.component_file import load_component
from grip_bt.task.catalog.ros_config import MOVE_GROUP, MoveGroupConfig
from grip_bt.task.catalog.start import Start

TIME_STARTS = 10.0
"""How long to wait for the first message of `/clock` [s]."""


def open_ros(
    opening: Opening, names: list[str], sensors: list[str], needs: Collection[str], stack: ExitStack
) -> Resources:
    """Start components and sensors; return them, the connection to ROS, and the run's clock where it is `/clock`.

    Args:
        needs: catalogue ids of the task's leaves.

    Raises:
        GripError: a component can't be started. A sensor that can't be opened says so when it is asked.
    """
    project, progress = opening.project, opening.progress
    if "ros/lookup_transform" in needs or any(project.file.sensors[name].given_in for name in sensors):
        provide_frames(progress)
    own = _has_own_domain(project, names, sensors, needs)
    poses, _ = mounted_frames(project.file.sensors)
    frames = robot_frames(project).with_poses(poses)
    folder = project.file.components or "components"

    def start(stack: ExitStack) -> tuple[int | None, Components]:
        domain = stack.enter_context(free_domain() if opening.apart else own_domain()) if own else None
        components = start_components(project.folder, names, domain, folder, frames, progress)
        stack.callback(components.close)
        return domain, components

    folders = project.component_folders()
    files = [load_component(folders[name]) for name in names if name in folders]
    fresh = any(file.start is not None and file.start.fresh for file in files)
    made_of = object() if fresh else (project.folder, files, own, project.file.qos)
    name = f"components {' '.join(names)}"
    domain, components = opening.equipment.get(name, made_of, start, lambda kept: kept[1].settled)
    components.bus.qos.update(project.file.qos)
    clock = simulated_clock(components.bus, stack) if project.file.simulated_time else None
    now = time.time if clock is None else clock.now
    ros = RosInterface(components.bus, Transforms(components.bus, frames), now)
    built = (
        f"interfaces built in {components.build_seconds:.1f} s" if components.build_seconds else "interfaces in cache"
    )
    servers: dict[str, Callable[[], int]] = {}
    for name in names:
        process = components.process(name)
        servers |= {name: partial(getattr, process, "pid")} if process is not None else {}
        where = f"ROS 2 server in process {process.pid}" if process is not None else "ROS 2 server already running"
        progress("component", f"{name}: {where}, ready after {components.ready_seconds:.1f} s; {built}")
    opened = open_sensors({name: project.file.sensors[name] for name in sensors}, ros, project.folder, domain)
    stack.callback(lambda: close_sensors(opened))
    for name, sensor in opened.items():
        topics = ", ".join(topic.topic for topic in project.file.sensors[name].topics.values())
        progress("sensor", f"{name}: {topics}" if isinstance(sensor, TopicSensor) else f"{name}: {sensor.reason}")
    clients = {name: components.client(name) for name in names}
    return Resources(components=clients, sensors=opened, ros=ros, clock=clock, servers=servers)


def simulated_clock(bus: Bus, stack: ExitStack) -> RosClock:
    """Return a clock that follows `/clock`. Raises ServerLostError: nobody publishes it."""
    clock = stack.enter_context(RosClock(bus))
    if not clock.wait_started(TIME_STARTS):
        reason = f"no simulated time within {TIME_STARTS:g} s: {clock.publishers()}"
        advice = "start the simulator, or take `simulated_time` out of grip.yaml"
        raise ServerLostError(f"/clock: {reason}. Fix: {advice}", server="/clock")
    return clock


def _has_own_domain(project: Project, names: list[str], sensors: list[str], needs: Collection[str]) -> bool:
    """Tell whether the run may have a domain of its own: not when the task needs something that runs already."""
    folders = project.component_folders()
    if project.file.simulated_time:
        return False
    started = all(name in folders and _starts(load_component(folders[name]).start) for name in names)
    driven = all(_starts(project.file.sensors[name].driver) for name in sensors)
    return started and driven and not any(node.startswith("ros/") for node in needs)


def _starts(start: Start | None) -> bool:
    return start is not None and start.run


def provide_frames(progress: Progress) -> None:
    """Have the messages of TF, built where they aren't installed; without them only fixed frames are known."""
    try:
        built = ensure_package("tf2_msgs")
        progress("frames", f"tf2_msgs, built in {built[0]}" if built else "tf2_msgs, as installed")
    except GripError as error:
        progress("frames", f"only those that never move: {error}")


def connect_messages(stack: ExitStack) -> RosMessages:
    """Connect to the named messages of a server that runs, in the user's own domain."""
    return RosMessages(stack.enter_context(Bus("grip_task_messages")))


def open_move_group(
    project: Project, description: RobotDescription, stack: ExitStack, bus: Bus | None = None
) -> MoveGroupPlanner:
    """Return the planner; see `commanders.with_move_group`."""
    file = project.file
    settings = file.ros.move_group if file.ros is not None else MoveGroupConfig()
    bus = bus if bus is not None else stack.enter_context(Bus("grip_planning"))

    def mount(arm: ArmConfig) -> ArmMapping:
        hand = file.hands.get(arm.hand) if arm.hand else None
        return ArmMapping.of(description, arm.group, hand.group if hand else "", settings.groups.get(arm.group, ""))

    planner = MoveGroupPlanner(
        MoveGroup(bus, settings.namespace, settings.wait),
        description,
        {arm.group: mount(arm) for arm in file.arms.values() if arm.planner == MOVE_GROUP},
        {arm.hand: mount(arm) for arm in file.arms.values() if arm.hand},
        settings.pipeline,
        settings.planner,
    )
    return stack.enter_context(planner)
