"""A simulated world as a ROS 2 robot: its joints, controllers and cameras, for any program that speaks ROS."""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from geometry_msgs.msg import WrenchStamped
from std_msgs.msg import Float64

from grip_bt.app.project.faults import check, faults_of_cameras, jerks_of_arms
from grip_bt.app.project.folder import Project
from grip_bt.app.project.worlds import room_of, world_of
from grip_bt.app.wiring.parts import Progress
from grip_bt.app.wiring.ros_world import SimulationServices
from grip_bt.base.errors import GripError, MissingPartError
from grip_bt.base.ports import Executor, HandPort
from grip_bt.commanders.description.tree import limits_of_joints
from grip_bt.commanders.scene_file import scene_text
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.interfaces.build import shell_setup
from grip_bt.ros.served import (
    CameraPublisher,
    publish_clock,
    publish_felt,
    publish_frames,
    publish_joints,
    wrench_to_message,
)
from grip_bt.ros.served_controllers import ControllerManager, FingerController, GripperController, TrajectoryController
from grip_sim.simulation import Simulation, start_simulation
from grip_sim.specs import CameraSpec

JOINT_STATES = "/joint_states"
SENSOR = "/{}_force_torque_sensor_broadcaster"
"""What serves the wrench of an arm or a link."""
PACKAGES = ("control_msgs", "controller_manager_msgs", "grip_msgs", "simulation_interfaces", "tf2_msgs")
LONG = 60.0
"""Simulated time is waited for in pieces of this length [s]; nothing happens between two of them."""


@dataclass(frozen=True)
class Served:
    """What a simulated world offers.

    Attributes:
        settings: what `grip.yaml` says to reach it.
        room: what stands in the world and never moves, as the text of a `.scene` file.
        setup: what a client's shell sources.
    """

    simulation: Simulation
    settings: Mapping[str, Any]
    room: str
    setup: str


@contextmanager
def serve_world(
    project: Project,
    world: str,
    seed: int,
    pace: float,
    progress: Progress,
    camera_rate: float = 2.0,
    simulated_time: bool = False,
) -> Iterator[Served]:
    """Simulate a world with the project's robot, and serve it over ROS 2; time goes on by itself.

    Args:
        project: with a robot, arms and hands; its sensors that say `camera` are served too. Where `ros/controllers`
            names actions these are served, else `/NAME_controller/follow_joint_trajectory`.
        pace: simulated seconds a second.
        progress: told of each part that came up.
        camera_rate: frames a second of each camera that somebody listens to.
        simulated_time: whether stamps are of simulated time, which `/clock` tells then.

    Raises:
        MissingPartError: the simulator or ROS isn't installed, or the project has no robot.
        UnknownNameError: there is no such world, or it has no such camera as a sensor names.
        GripError: a controller of the project isn't a trajectory controller.
    """
    spec = world_of(project, seed, world)
    check(faults_of_cameras(project, world))
    if project.file.robot is None:
        raise MissingPartError("a robot to simulate", "name one in grip.yaml: `robot: panda_allegro`")
    arms = {name: arm.group for name, arm in project.file.arms.items() if not arm.arms}
    groups = arms | {name: hand.group for name, hand in project.file.hands.items()}
    actions, description = {name: _action(project, name) for name in groups}, project.description()
    with ExitStack() as stack:
        progress("starting", "the simulator")
        jerks = jerks_of_arms(project.file.arms, description)
        simulation = stack.enter_context(start_simulation(replace(spec, jerks=jerks), pace))
        names = ", ".join(thing.name for thing in spec.objects)
        progress("simulator", f"SAPIEN in process {simulation.pid}, world {world!r}, seed {seed}: {names}")
        bus = stack.enter_context(Bus("grip_sim"))
        executors: dict[str, Executor | HandPort] = {
            name: simulation.hand(group) if name in project.file.hands else simulation.executor(group, from_here=True)
            for name, group in groups.items()
        }
        controllers = []
        for name, executor in executors.items():
            way, action = actions[name]
            fingers = GripperController if way == "gripper" else FingerController
            kind = fingers if name in project.file.hands else TrajectoryController
            made = kind(bus, action, executor, limits_of_joints(description, groups[name]))
            stack.callback(made.close)
            controllers.append(made)
            progress("controller", f"{action}: {len(executor.joint_names)} joints of {name}")
        progress("controllers", ", ".join(ControllerManager(bus, controllers).services))
        joints = project.file.ros.joint_states if project.file.ros is not None else JOINT_STATES
        now = (lambda: simulation.clock.simulated) if simulated_time else time.time
        measured = tuple(executors.values())
        stack.callback(publish_joints(bus, joints, measured, now).close)
        progress("joints", joints)
        if simulated_time:
            stack.callback(publish_clock(bus, now).close)
            progress("clock", "/clock")
        cameras, fixed = {}, {}
        for name, sensor in project.file.sensors.items():
            if sensor.camera is not None:
                served = CameraPublisher(bus, name, simulation.camera(sensor.camera), camera_rate, now)
                stack.callback(served.close)
                said = {part: served.topics[part] for part in ("image", "depth", "info")}
                seen = next(each for each in simulation.spec.cameras if each.name == sensor.camera)
                cameras[name] = {**said, "mount": _mount(served.frame, seen)}
                fixed[served.frame] = seen.info().pose
                progress("camera", ", ".join(served.topics.values()))
        stack.callback(publish_frames(bus, description, measured, fixed, now).close)
        progress("frames", "/tf, /tf_static, /robot_description")
        stack.enter_context(_time_going_on(simulation))
        SimulationServices(bus, simulation, partial(world_of, project, world=world), project.folder, now)
        progress("world", "/spawn_entity, /reset_simulation ... (simulation_interfaces), /grip_sim/inject_fault")
        felt = _serve_touch(stack, bus, project, simulation, now)
        progress("touch", f"{', '.join(each['wrench'] for each in felt.values() if 'wrench' in each)} and of fingers")
        reached = {name: {way: action, **felt.get(name, {})} for name, (way, action) in actions.items()}
        settings = {"ros": {"joint_states": joints, "controllers": reached, "cameras": cameras}}
        yield Served(simulation, settings, scene_text("room", room_of(simulation.spec)), shell_setup(*PACKAGES))


def _serve_touch(
    stack: ExitStack, bus: Bus, project: Project, simulation: Simulation, now: Callable[[], float]
) -> dict[str, dict[str, Any]]:
    """Publish what wrists and hands feel, until the stack ends, and return what `ros/controllers` says to hear it."""
    file, found = project.file, dict[str, dict[str, Any]]()
    told = file.ros.controllers if file.ros is not None else {}
    hands = {name: simulation.hand(hand.group) for name, hand in file.hands.items()}

    def serve(topics: Mapping[str, str], measure: Callable[[], Mapping[str, Any]], *how: Any) -> None:
        stack.callback(publish_felt(bus, topics, now, measure, *how).close)

    for name, arm in file.arms.items():
        if arm.hand and not arm.arms:
            wrist = hands[arm.hand].wrench
            topic = (told[name].wrench if name in told else None) or SENSOR.format(name) + "/wrench"
            serve(dict.fromkeys(wrist(), topic), wrist, WrenchStamped, wrench_to_message)
            found[name] = {"wrench": topic}
    for name, hand in hands.items():
        sensors = {link: SENSOR.format(re.sub(r"\W", "_", link)) for link in hand.link_wrenches()}
        forces, speeds = ({link: f"{each}/{part}" for link, each in sensors.items()} for part in ("wrench", "slip"))
        serve(forces, hand.link_wrenches, WrenchStamped, wrench_to_message)
        serve(speeds, hand.slips, Float64, lambda link, speed, time: Float64(data=speed))
        slips = {
            link: {"topic": topic, "message": "std_msgs/msg/Float64", "field": "data"} for link, topic in speeds.items()
        }
        found[name] = {"contacts": {link: {"topic": topic} for link, topic in forces.items()}, "slips": slips}
    return found


def _action(project: Project, name: str) -> tuple[str, str]:
    """Return the kind and the name of an action of an arm or a hand.

    Raises GripError: it is reached in another way, which isn't simulated, or it is no gripper.
    """
    controllers = project.file.ros.controllers if project.file.ros is not None else {}
    if name not in controllers:
        return "trajectory", f"/{name}_controller/follow_joint_trajectory"
    said, where = controllers[name], f"grip.yaml: ros/controllers/{name}"
    if said.trajectory is not None:
        return "trajectory", said.trajectory
    if said.gripper is None:
        raise GripError(
            f"{where}: only `trajectory` and `gripper` controllers are simulated; "
            "give the simulation a project of its own"
        )
    joints = project.description().group(project.file.hands[name].group)
    if len(joints) != 1:
        raise GripError(f"{where}: a gripper has one driven joint, and {name} has {len(joints)}: say `trajectory`")
    return "gripper", said.gripper


def _mount(frame: str, spec: CameraSpec) -> dict[str, object]:
    pose = spec.info().pose
    place = {**({"on": spec.link} if spec.link else {}), "position": [round(float(v), 6) for v in pose.position]}
    return {"frame": frame, **place, "quaternion": [round(float(v), 9) for v in pose.quaternion]}


@contextmanager
def _time_going_on(simulation: Simulation) -> Iterator[None]:
    """Have physics advance though nothing is asked of it."""
    over = threading.Event()

    def wait() -> None:
        try:
            while not over.is_set():
                simulation.settle(LONG)
        except GripError:
            return  # the simulator has ended, as it does when it is closed

    threading.Thread(target=wait, name="grip_sim_time", daemon=True).start()
    try:
        yield
    finally:
        over.set()
