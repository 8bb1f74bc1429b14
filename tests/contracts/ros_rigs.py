"""Rigs over controllers of ROS 2 in a process of their own; their time is the wall's."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from contract_rigs import ExecutorRig, HandRig
from on_the_way import SLOW
from patience import PATIENCE, until
from server_process import serving

from grip_bt.base.values import JointState
from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.hand import HandCommander
from grip_bt.commanders.joined import JoinedExecutor
from grip_bt.commanders.pausing import PausableHand
from grip_bt.commanders.trajectory.stopping import ACCELERATION

SERVERS = Path(__file__).parents[1] / "ros" / "data"
NAMES = ("joint_a", "joint_b")
FINGERS = ("finger_1", "finger_2")
THEIRS = 4.0
"""How hard the controllers brake that stand for real ones [rad/s^2]."""
SIDES = {"left": {"left_joint": 0.0}, "right": {"right_joint": 0.0}}


@contextmanager
def controllers() -> Iterator[tuple[Any, Any]]:
    """Start the robot of the ROS tests, and a Panda; give a bus on their domain, and what is measured of the joints."""
    from patient_bus import PatientBus, joints_of

    from grip_bt.ros.environment import free_domain
    from grip_bt.ros.interfaces.build import ensure_package

    messages = [*ensure_package("control_msgs"), *ensure_package("controller_manager_msgs")]
    panda = build_robot("panda_allegro").named_state("arm", "home").as_mapping()
    joints = json.dumps({**SIDES, "panda": panda})
    with (
        free_domain() as domain,
        serving(SERVERS / "controller_server.py", joints, domain=domain, overlays=messages),
        PatientBus(f"contract_{domain}", domain_id=domain) as bus,
    ):
        yield bus, joints_of(bus, NAMES)


@contextmanager
def trajectory_executor(ros_robot: tuple[Any, Any]) -> Iterator[ExecutorRig]:
    from grip_bt.ros.controllers import TrajectoryExecutor

    bus, states = ros_robot
    executor = TrajectoryExecutor(bus, "/arm/follow_joint_trajectory", NAMES, states, wait=PATIENCE)
    until(lambda: executor.steerable, "the topic isn't heard")
    yield spoilt(_rig(executor, THEIRS), 4.0)


@contextmanager
def topic_executor(ros_robot: tuple[Any, Any]) -> Iterator[ExecutorRig]:
    from grip_bt.ros.controllers import TopicExecutor

    bus, states = ros_robot
    yield spoilt(_rig(TopicExecutor(bus, "/arm/joint_trajectory", NAMES, states)), 4.0)


@contextmanager
def streamed_executor(ros_robot: tuple[Any, Any]) -> Iterator[ExecutorRig]:
    from grip_bt.ros.controllers import StreamedExecutor

    bus, states = ros_robot
    yield _rig(StreamedExecutor(bus, "/stream/commands", NAMES, states))


@contextmanager
def joined_trajectory_executors(ros_robot: tuple[Any, Any]) -> Iterator[ExecutorRig]:
    """Two controllers of one joint each, as one: what one of them gives up, the other one doesn't go on with."""
    from grip_bt.ros.controllers import TrajectoryExecutor

    bus, states = ros_robot
    parts = [
        TrajectoryExecutor(bus, f"/{side}/follow_joint_trajectory", tuple(joints), states, wait=PATIENCE)
        for side, joints in SIDES.items()
    ]
    yield spoilt(_rig(JoinedExecutor(*parts), THEIRS), 4.0)


@contextmanager
def gripper(ros_robot: tuple[Any, Any]) -> Iterator[HandRig]:
    from grip_bt.ros.controllers import GripperHand

    bus, states = ros_robot
    hand = GripperHand(bus, "/claw/gripper_cmd", "claw", states, wait=PATIENCE)
    _say(ros_robot, "claw_speed", 1.0)
    rig = _hand_rig(hand, ("claw",), (1.0, 0.0), ros_robot)
    rig.slow_down = lambda: _say(ros_robot, "claw_speed", 1 / SLOW)
    yield rig


@contextmanager
def controlled_hand(ros_robot: tuple[Any, Any]) -> Iterator[HandRig]:
    from grip_bt.ros.controllers import ControlledHand, TrajectoryExecutor

    bus, states = ros_robot
    hand = ControlledHand(TrajectoryExecutor(bus, "/fingers/follow_joint_trajectory", FINGERS, states, wait=PATIENCE))
    yield _hand_rig(hand, FINGERS, (0.0, 1.0), ros_robot)


@contextmanager
def commanded_ros_hand(ros_robot: tuple[Any, Any]) -> Iterator[HandRig]:
    with controlled_hand(ros_robot) as rig:
        hand = HandCommander("right", PausableHand(rig.port), {"open": rig.open, "closed": rig.closed})
        yield HandRig(hand, rig.let_pass, rig.open, rig.closed, rig.offer, regulates=False)


def spoilt(rig: ExecutorRig, at: float) -> ExecutorRig:
    """Return a rig whose spoiled motions bring the first joint to a place that its controller gives up half-way to."""

    def spoil() -> None:
        start = rig.port.state()
        rig.goal = JointState(start.names, [at, *start.position[1:] + 0.3])

    rig.spoil = spoil
    return rig


def _rig(executor: Any, braking: float = ACCELERATION) -> ExecutorRig:
    start = executor.state()
    # To and fro: the robot is one for all tests, and stands where the last one has left it.
    way = [0.5 if position < 0.5 else -0.5 for position in start.position]
    return ExecutorRig(executor, time.sleep, JointState(start.names, start.position + way), braking=braking)


def _hand_rig(port: Any, names: Sequence[str], at: tuple[float, float], ros_robot: tuple[Any, Any]) -> HandRig:
    """Return a rig whose hand is open, with nothing in it."""
    opened, closed = (JointState(tuple(names), [position] * len(names)) for position in at)
    _offer(ros_robot, False)
    operation = port.move(opened, 1.0)
    assert operation.wait(PATIENCE)
    operation.result()
    return HandRig(port, time.sleep, opened, closed, lambda: _offer(ros_robot, True), braking=THEIRS)


def _offer(ros_robot: tuple[Any, Any], there: bool) -> None:
    _say(ros_robot, "thing", float(there))


def _say(ros_robot: tuple[Any, Any], name: str, value: float) -> None:
    """Tell the robot about itself, and wait until it tells that back."""
    from std_msgs.msg import Float64

    bus, states = ros_robot
    said = bus.writer("std_msgs/msg/Float64", f"/{name}").publish(Float64(data=value), 1)
    assert said.wait(PATIENCE)
    said.result()
    until(lambda: states.state([name]).position[0] == value, f"the robot doesn't hear of its {name}")
