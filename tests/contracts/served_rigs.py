"""Rigs over what `grip sim` serves, reached by what it says to put into grip.yaml; its time is the wall's."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from contract_rigs import ExecutorRig
from patience import PATIENCE, until

from grip_bt.base.values import JointState
from grip_bt.commanders.description.load import build_robot

if TYPE_CHECKING:
    from grip_bt.app.wiring.ros_simulation import Served
    from grip_bt.ros.client.bus import Bus
    from grip_bt.task.catalog.ros_config import ControllerConfig

PROJECT = """grip: 1
robot: panda_allegro
arms: {right: {group: arm, hand: right_hand}}
hands: {right_hand: {group: hand}}
world: held
"""
WORLD = """grip: 1
fixtures: {table: {box: [0.7, 1.2, 0.1], at: [0.65, 0, -0.1]}}
objects: {thing: {shape: cylinder, radius: 0.03, height: 0.18, at: [0.9, 0.45, 0]}}
"""


@contextmanager
def served_world(folder: Path) -> Iterator[tuple[Served, Bus, Mapping[str, ControllerConfig]]]:
    """Serve a world of a project in a folder; give it, somebody else's bus, and the controllers of `ros:`."""
    from patient_bus import PatientBus

    from grip_bt.app.project.folder import find_project
    from grip_bt.app.wiring.ros_simulation import serve_world
    from grip_bt.ros.environment import free_domain
    from grip_bt.task.catalog.ros_config import RosRobotConfig

    (folder / "grip.yaml").write_text(PROJECT)
    (folder / "worlds").mkdir()
    (folder / "worlds" / "held.yaml").write_text(WORLD)
    with free_domain() as domain, pytest.MonkeyPatch.context() as patch, ExitStack() as stack:
        patch.setenv("ROS_DOMAIN_ID", str(domain))
        world = stack.enter_context(serve_world(find_project(folder), "held", 0, 1.0, lambda part, detail: None))
        bus = stack.enter_context(PatientBus(f"served_{domain}", domain_id=domain))
        yield world, bus, RosRobotConfig.model_validate(world.settings["ros"]).controllers


@contextmanager
def served_executor(served_robot: tuple[Any, Any, Any]) -> Iterator[ExecutorRig]:
    from patient_bus import joints_of

    from grip_bt.ros.controllers import TrajectoryExecutor

    _, bus, told = served_robot
    robot = build_robot("panda_allegro")
    names, limits = robot.group("arm"), robot.acceleration_limits
    states = joints_of(bus, names)
    executor = TrajectoryExecutor(bus, told["right"].trajectory, names, states, limits, wait=PATIENCE)
    until(lambda: executor.steerable, "the topic isn't heard")
    start = executor.state()
    way = np.array([0.5, 0, 0.2, 0, 0, 0, 0.4]) * (1 if start.position[0] < 0.25 else -1)
    goal = JointState(start.names, start.position + way)
    yield ExecutorRig(executor, time.sleep, goal, braking=np.array([limits[name] for name in names]))
