"""Adapters under contract. Another adapter of a port is one more entry in its table here.

A rig holds an adapter and the means to let its time pass: `wait(operation)` until it ends, `let_pass(seconds)`.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count
from typing import Any

import numpy as np
import pytest
from contract_rigs import PATIENT, ArmRig, ExecutorRig, HandRig, Patient
from ros_arm_rigs import arm_of_controllers, arm_of_move_group, move_group, move_group_executor
from ros_rigs import (
    commanded_ros_hand,
    controlled_hand,
    controllers,
    gripper,
    joined_trajectory_executors,
    streamed_executor,
    topic_executor,
    trajectory_executor,
)
from served_rigs import served_executor, served_world
from simulated_rigs import (
    commanded_simulated_arm,
    commanded_simulated_hand,
    panda_planner,
    simulated_executor,
    simulated_hand_port,
)
from timed import BRAKING, ManualClock, OnClock, TimedArm, TimedExecutor, TimedHand

from grip_bt.base.failures import ExecutionAbortedError
from grip_bt.base.values import JointState, Pose
from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.hand import HandCommander
from grip_bt.commanders.joined import JoinedExecutor
from grip_bt.commanders.pausing import PausableExecutor, PausableHand


@contextmanager
def fake_executor() -> Iterator[ExecutorRig]:
    clock, spoiled = ManualClock(), list[ExecutionAbortedError]()
    start, goal = JointState(("a", "b"), [0.1, -0.2]), JointState(("a", "b"), [0.6, 0.1])
    script = (spoiled.pop() if spoiled else None for _ in count())
    executor = TimedExecutor(start, OnClock(clock), script)
    yield ExecutorRig(
        executor, clock.advance, goal, lambda: spoiled.append(ExecutionAbortedError("spoiled")), exact=True
    )


def _fingers() -> tuple[JointState, JointState, JointState]:
    states = build_robot("panda_allegro").named_states["hand"]
    half = (states["open"].position + states["closed"].position) / 2
    return states["open"], states["closed"], JointState(states["open"].names, half)


@contextmanager
def fake_hand_port() -> Iterator[HandRig]:
    clock = ManualClock()
    opened, closed, thing = _fingers()
    port = TimedHand(opened, OnClock(clock))

    def put(what: JointState | None) -> None:
        port.thing = what

    yield HandRig(
        port, clock.advance, opened, closed, lambda: put(thing), lambda: put(None), exact=True, braking=BRAKING
    )


@contextmanager
def commanded_fake_hand() -> Iterator[HandRig]:
    with fake_hand_port() as rig:
        states = build_robot("panda_allegro").named_states["hand"]
        yield HandRig(HandCommander("right", rig.port, states), rig.let_pass, rig.open, rig.closed, rig.offer, rig.take)


@contextmanager
def fake_arm() -> Iterator[ArmRig]:
    clock = ManualClock()
    arm = TimedArm("right", Pose([0.3, -0.4, 0.5]), OnClock(clock))
    away = JointState(arm.state().names, [0.5, 0.0, 0.3, 0.0, 0.2, 0.1])
    yield ArmRig(arm, clock.advance, away, np.array([0.0, 0.05, 0.1]), exact=True)


@contextmanager
def commanded_arm() -> Iterator[ArmRig]:
    """The real commander, planning in its process, on a fake executor."""
    from grip_bt.commanders.arm import ArmCommander, ArmSetup
    from grip_bt.commanders.kinematics.model import RobotModel
    from grip_bt.commanders.scene import PlanningScene

    clock = ManualClock()
    model = RobotModel(build_robot("panda_allegro"))
    home, opened = (model.description.named_state(*s) for s in (("arm", "home"), ("hand", "open")))
    executor = TimedExecutor(home, OnClock(clock))
    scene = PlanningScene({"hand": lambda: model.grasp_pose(executor.state())})
    scene.set_box("table", (0.7, 1.2, 0.1), Pose([0.65, 0, -0.05]))
    setup = ArmSetup("right", hand="hand", settings=PATIENT)
    arm = ArmCommander(setup, model, Patient(panda_planner()), executor, scene, lambda: [opened])
    away = JointState(home.names, home.position + [0.5, 0, 0.3, 0, 0, 0.2, 0])
    yield ArmRig(arm, clock.advance, away, np.array([0.0, 0.02, -0.1]), exact=True)


@contextmanager
def held_executor() -> Iterator[ExecutorRig]:
    """An executor that can only be stopped, made one that can be held."""
    with fake_executor() as rig:
        rig.port = PausableExecutor(rig.port)
        yield rig


@contextmanager
def held_hand_port() -> Iterator[HandRig]:
    with fake_hand_port() as rig:
        yield HandRig(
            PausableHand(rig.port), rig.let_pass, rig.open, rig.closed, rig.offer, rig.take, exact=True, braking=BRAKING
        )


@contextmanager
def held_trajectory_executor(ros_robot: tuple[Any, Any]) -> Iterator[ExecutorRig]:
    with trajectory_executor(ros_robot) as rig:
        rig.port = PausableExecutor(rig.port)
        yield rig


@contextmanager
def held_streamed_executor(ros_robot: tuple[Any, Any]) -> Iterator[ExecutorRig]:
    with streamed_executor(ros_robot) as rig:
        rig.port = PausableExecutor(rig.port)
        yield rig


@contextmanager
def held_topic_executor(ros_robot: tuple[Any, Any]) -> Iterator[ExecutorRig]:
    with topic_executor(ros_robot) as rig:
        rig.port = PausableExecutor(rig.port)
        yield rig


@contextmanager
def joined_fake_executors() -> Iterator[ExecutorRig]:
    """Two executors of one joint each, as one."""
    clock = ManualClock()
    schedule = OnClock(clock)
    parts = [TimedExecutor(JointState((name,), [at]), schedule) for name, at in (("a", 0.1), ("b", -0.2))]
    yield ExecutorRig(JoinedExecutor(*parts), clock.advance, JointState(("a", "b"), [0.6, 0.1]), exact=True)


@pytest.fixture(scope="module")
def ros_robot() -> Iterator[Any]:
    """Return a bus and the joint states of one robot for the tests of a file, which alone bear what it costs."""
    with controllers() as made:
        yield made


@pytest.fixture(scope="module")
def ros_move_group() -> Iterator[Any]:
    """Return a bus and the joint states of one move_group, likewise."""
    with move_group() as made:
        yield made


@pytest.fixture(scope="module")
def served_robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Return a served world, a bus and its controllers, likewise."""
    with served_world(tmp_path_factory.mktemp("served")) as made:
        yield made


ROS = (pytest.mark.ros, pytest.mark.slow)
MARKS = {
    "simulated": pytest.mark.sim,
    "ros_trajectory": ROS,
    "ros_stream": ROS,
    "ros_topic": ROS,
    "ros_trajectory_held": ROS,
    "ros_stream_held": ROS,
    "ros_topic_held": ROS,
    "ros_joined": ROS,
    "ros_gripper": ROS,
    "ros_fingers": ROS,
    "ros_hand": ROS,
    "ros_controller": ROS,
    "move_group": ROS,
    "served": (*ROS, pytest.mark.sim),
}
EXECUTORS = {
    "fake": fake_executor,
    "held": held_executor,
    "joined": joined_fake_executors,
    "simulated": simulated_executor,
    "ros_trajectory": trajectory_executor,
    "ros_stream": streamed_executor,
    "ros_topic": topic_executor,
    "ros_trajectory_held": held_trajectory_executor,
    "ros_stream_held": held_streamed_executor,
    "ros_joined": joined_trajectory_executors,
    "move_group": move_group_executor,
    "served": served_executor,
}
PAUSABLE = {
    "held": held_executor,
    "ros_trajectory_held": held_trajectory_executor,
    "ros_stream_held": held_streamed_executor,
    "ros_topic_held": held_topic_executor,
}
HAND_PORTS = {
    "fake": fake_hand_port,
    "held": held_hand_port,
    "simulated": simulated_hand_port,
    "ros_gripper": gripper,
    "ros_fingers": controlled_hand,
}
HANDS = {"fake": commanded_fake_hand, "simulated": commanded_simulated_hand, "ros_hand": commanded_ros_hand}
ARMS = {
    "fake": fake_arm,
    "commander": commanded_arm,
    "simulated": commanded_simulated_arm,
    "ros_controller": arm_of_controllers,
    "move_group": arm_of_move_group,
}


def _rigs(table: dict[str, Callable[[], Any]]) -> Any:
    @pytest.fixture(params=[pytest.param(make, id=name, marks=MARKS.get(name, ())) for name, make in table.items()])
    def rig(request: pytest.FixtureRequest) -> Iterator[Any]:
        needs = [request.getfixturevalue(name) for name in inspect.signature(request.param).parameters]
        with request.param(*needs) as made:
            yield made

    return rig


executor_rig = _rigs(EXECUTORS)
pausable_rig = _rigs(PAUSABLE)
hand_port_rig = _rigs(HAND_PORTS)
hand_rig = _rigs(HANDS)
arm_rig = _rigs(ARMS)
