"""What a run has of ROS: components, sensors on topics, frames, and the connection itself."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from contextlib import ExitStack
from typing import TYPE_CHECKING

from grip_bt.base.errors import GripError
from grip_bt.base.failures import ServerLostError
from grip_bt.ros.domain import own_domain
from grip_bt.task.catalog.component_file import Start, load_component

from ..project.folder import Project
from ..project.frames import robot_frames
from .parts import Progress, Resources

if TYPE_CHECKING:
    from ..project.folder import Project

if TYPE_CHECKING:
    from grip_bt.ros.client.bus import Bus

TIME_STARTS = 10.0
"""How long to wait for the first message of `/clock` [s]."""


def open_ros(
    project: Project,
    names: list[str],
    sensors: list[str],
    needs: Collection[str],
    resources: Resources,
    stack: ExitStack,
    progress: Progress,
) -> None:
    """Start components and sensors and put them, with the connection to ROS, into `resources`.

    Args:
        project: whose components, sensors and robot.
        names: components to start.
        sensors: sensors on topics to open.
        needs: catalogue ids of the task's leaves.
        resources: filled in.
        stack: closes what was started.
        progress: told of each part that came up.

    Raises:
        GripError: a component can't be started. A sensor that can't be opened says so when it is asked.
    """
    from grip_bt.ros.components import start_components
    from grip_bt.ros.frames import mounted_frames
    from grip_bt.ros.interface import RosDoor
    from grip_bt.ros.sensing import TopicSensor, close_sensors, open_sensors
    from grip_bt.ros.transforms import Transforms

    if "ros/lookup_transform" in needs or any(project.file.sensors[name].given_in for name in sensors):
        provide_frames(progress)
    domain = _domain(project, names, sensors, needs, stack)
    poses, _ = mounted_frames(project.file.sensors)
    frames = robot_frames(project).with_poses(poses)
    folder = project.file.components or "components"

    def begun(package: str) -> None:
        progress("interfaces", f"{package} is built now, once for all runs; this takes some seconds")

    components = start_components(project.folder, names, domain, folder, frames, begun)
    stack.callback(components.close)
    resources.components = {name: components.client(name) for name in names}
    now = _take_time(components.bus, resources, stack) if project.file.simulated_time else time.time
    door = RosDoor(components.bus, Transforms(components.bus, frames), now)
    resources.ros = door
    built = (
        f"interfaces built in {components.build_seconds:.1f} s" if components.build_seconds else "interfaces in cache"
    )
    for name in names:
        process = components.process(name)
        where = f"ROS 2 server in process {process.pid}" if process is not None else "ROS 2 server already running"
        progress("component", f"{name}: {where}, ready after {components.ready_seconds:.1f} s; {built}")
    opened = open_sensors({name: project.file.sensors[name] for name in sensors}, door, project.folder, domain)
    stack.callback(lambda: close_sensors(opened))
    resources.sensors = opened
    for name, sensor in opened.items():
        topics = ", ".join(topic.topic for topic in project.file.sensors[name].topics.values())
        progress("sensor", f"{name}: {topics}" if isinstance(sensor, TopicSensor) else f"{name}: {sensor.reason}")


def _take_time(bus: Bus, resources: Resources, stack: ExitStack) -> Callable[[], float]:
    """Have the run's clock follow `/clock`, and return it.

    Raises:
        ServerLostError: nobody publishes it.
    """
    from grip_bt.ros.clock import RosClock

    clock = stack.enter_context(RosClock(bus))
    if not clock.wait_started(TIME_STARTS):
        reason = f"no simulated time within {TIME_STARTS:g} s: {clock.publishers()}"
        advice = "start the simulator, or take `simulated_time` out of grip.yaml"
        raise ServerLostError(f"/clock: {reason}. To mend it: {advice}", server="/clock")
    resources.clock = clock
    return clock.now


def _domain(
    project: Project, names: list[str], sensors: list[str], needs: Collection[str], stack: ExitStack
) -> int | None:
    """Return a domain of the run's own, or the user's when something that runs already is part of the task."""
    folders = project.component_folders()
    if project.file.simulated_time:
        return None
    started = all(name in folders and _starts(load_component(folders[name]).start) for name in names)
    driven = all(_starts(project.file.sensors[name].driver) for name in sensors)
    if started and driven and not any(node.startswith("ros/") for node in needs):
        return stack.enter_context(own_domain())
    return None


def _starts(start: Start | None) -> bool:
    return start is not None and start.run


def provide_frames(progress: Progress) -> None:
    """Have the messages of TF, built where they aren't installed; without them only fixed frames are known."""
    from grip_bt.ros.interfaces.bundled import provide

    try:
        built = provide("tf2_msgs")
        progress("frames", f"tf2_msgs, built in {built[0]}" if built else "tf2_msgs, as installed")
    except GripError as error:
        progress("frames", f"only those that never move: {error}")
