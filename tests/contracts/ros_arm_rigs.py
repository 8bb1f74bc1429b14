"""Rigs of the arm commander over ROS 2: our planner and a trajectory controller, and MoveIt's move_group for both."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

import numpy as np
from contract_rigs import PATIENT, ArmRig, ExecutorRig, Patient
from patience import PATIENCE
from ros_rigs import SERVERS, THEIRS, spoilt
from server_process import serving
from simulated_rigs import panda_planner

from grip_bt.base.values import JointState, Pose, Trajectory
from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.commanders.pausing import PausableExecutor

ROBOT = "panda_allegro"


@contextmanager
def move_group() -> Iterator[tuple[Any, Any]]:
    """Start the stand-in of move_group for a Panda; give a bus on its domain, and what is measured of the joints."""
    from patient_bus import PatientBus, joints_of

    from grip_bt.ros.environment import free_domain
    from grip_bt.ros.interfaces.build import ensure_package

    messages = ensure_package("moveit_msgs")
    with (
        free_domain() as domain,
        serving(SERVERS / "move_group_server.py", ROBOT, domain=domain, overlays=messages),
        PatientBus(f"contract_{domain}", domain_id=domain) as bus,
    ):
        yield bus, joints_of(bus, model().description.group("arm"))


@cache
def model() -> RobotModel:
    return RobotModel(build_robot(ROBOT))


@contextmanager
def move_group_executor(ros_move_group: tuple[Any, Any]) -> Iterator[ExecutorRig]:
    executor = _by_move_group(ros_move_group)
    _bring_home(executor)
    home = executor.state()
    goal = JointState(home.names, home.position + [0.5, 0, 0.2, 0, 0, 0, 0.4])
    yield spoilt(ExecutorRig(executor, time.sleep, goal, braking=THEIRS), 2.6)


@contextmanager
def arm_of_controllers(ros_robot: tuple[Any, Any]) -> Iterator[ArmRig]:
    from grip_bt.ros.controllers import TrajectoryExecutor

    bus, states = ros_robot
    joints = model().description.group("arm")
    executor = PausableExecutor(
        TrajectoryExecutor(bus, "/panda/follow_joint_trajectory", joints, states, wait=PATIENCE)
    )
    yield _arm_rig(executor, panda_planner())


@contextmanager
def arm_of_move_group(ros_move_group: tuple[Any, Any]) -> Iterator[ArmRig]:
    """MoveIt plans and moves; our planner answers what is about given motions, as in a project."""
    from grip_bt.app.wiring.commanders import PlannerByName
    from grip_bt.ros.moveit import ArmMapping, MoveGroup, MoveGroupPlanner

    bus, _ = ros_move_group
    description = model().description
    mount = ArmMapping.of(description, "arm", "hand")
    theirs = MoveGroupPlanner(MoveGroup(bus, wait=PATIENCE), description, {"arm": mount}, {"hand": mount})
    with theirs:
        planner = PlannerByName(panda_planner(), {"move_group": theirs})
        yield _arm_rig(PausableExecutor(_by_move_group(ros_move_group)), planner, "move_group")


def _by_move_group(ros_move_group: tuple[Any, Any]) -> Any:
    from grip_bt.ros.moveit import MoveGroupExecutor

    bus, states = ros_move_group
    return MoveGroupExecutor(bus, "/execute_trajectory", model().description.group("arm"), states)


def _arm_rig(executor: Any, planner: Any, name: str = "RRTConnect") -> ArmRig:
    from grip_bt.commanders.arm import ArmCommander, ArmSetup
    from grip_bt.commanders.scene import PlanningScene

    _bring_home(executor)
    home, opened = (model().description.named_state(*s) for s in (("arm", "home"), ("hand", "open")))
    scene = PlanningScene({"hand": lambda: model().grasp_pose(executor.state())})
    scene.set_box("table", (0.7, 1.2, 0.1), Pose([0.65, 0, -0.05]))
    service = Patient(planner)
    setup = ArmSetup("right", hand="hand", settings=PATIENT.model_copy(update={"planner": name}))
    arm = ArmCommander(setup, model(), service, executor, scene, lambda: [opened])
    away = JointState(home.names, home.position + [0.5, 0, 0.3, 0, 0, 0.2, 0])
    return ArmRig(arm, time.sleep, away, np.array([0.0, 0.02, -0.1]))


def _bring_home(executor: Any) -> None:
    """Go straight: the robot is one for all tests, and stands where the last one has left it."""
    start, home = executor.state(), model().description.named_state("arm", "home")
    way = np.stack([start.position, home.ordered(start.names)])
    if np.abs(way[1] - way[0]).max() > 1e-6:
        operation = executor.execute(Trajectory(start.names, np.array([0.0, 0.5]), way))
        assert operation.wait(PATIENCE)
        operation.result()
