"""Rigs over controllers of ROS 2 in a process of their own; their time is the wall's."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from contract_rigs import ExecutorRig
from server_process import serving

from grip_bt.values import JointState

SERVER = Path(__file__).parents[1] / "ros" / "data" / "controller_server.py"
NAMES = ("joint_a", "joint_b")


@contextmanager
def controllers() -> Iterator[tuple[Any, Any]]:
    """Start the robot of the ROS tests; give a bus on its domain, and what it says about its joints."""
    import grip_bt.ros  # noqa: F401 - its settings come before any message package
    from grip_bt.app.domain import free_domain
    from grip_bt.ros.bus import Bus
    from grip_bt.ros.controllers import JointStates
    from grip_bt.ros.definitions import provide

    messages = [*provide("control_msgs"), *provide("controller_manager_msgs")]
    with free_domain() as domain, serving(SERVER, domain=domain, overlays=messages):
        with Bus(f"contract_{domain}", domain_id=domain) as bus:
            states = JointStates(bus)
            states.wait_for(NAMES, 15.0)
            yield bus, states


@contextmanager
def trajectory_executor(ros_robot: tuple[Any, Any]) -> Iterator[ExecutorRig]:
    from grip_bt.ros.controllers import TrajectoryExecutor

    bus, states = ros_robot
    yield _rig(TrajectoryExecutor(bus, "/arm/follow_joint_trajectory", NAMES, states))


@contextmanager
def streamed_executor(ros_robot: tuple[Any, Any]) -> Iterator[ExecutorRig]:
    from grip_bt.ros.controllers import StreamedExecutor

    bus, states = ros_robot
    yield _rig(StreamedExecutor(bus, "/stream/commands", NAMES, states))


def _rig(executor: Any) -> ExecutorRig:
    start = executor.state()
    # To and fro: the robot is one for all tests, and stands where the last one has left it.
    way = [0.5 if position < 0.5 else -0.5 for position in start.position]
    return ExecutorRig(executor, time.sleep, JointState(start.names, start.position + way))
