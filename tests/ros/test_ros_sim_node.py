"""The simulator as a ROS 2 robot: reached as a real one is, by the same adapters, from other processes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator

import numpy as np
import pytest
import yaml
from patience import until
from simulated_robot import PATIENCE, PROJECT, World, simulated_robot

from grip_bt.base.failures import CanceledError, GoalRejectedError
from grip_bt.base.values import JointState, Trajectory

TASK = """grip: 1
name: look_and_move
data: {cloud: PointCloud}
root:
  kind: sequence
  children:
    home: {node: arm/move_to, with: {state: home}}
    open: {node: hand/open, with: {hand: right_hand}}
    look: {node: sensor/overhead, out: {points: cloud}}
    obstacles: {node: scene/update_from_cloud, in: {cloud: cloud}}
    close: {node: hand/posture, with: {hand: right_hand, posture: closed}}  # there is nothing to be felt
"""


@pytest.fixture(scope="module")
def world(own_domain, tmp_path_factory) -> Iterator[World]:
    """Start the simulator, and write what it says into the project's file."""
    folder = tmp_path_factory.mktemp("simulated")
    (folder / "task.yaml").write_text(TASK)
    with simulated_robot(folder, own_domain, "--seed", "4", "--room", "room.scene") as running:
        yield running


@pytest.fixture
def bus(world):
    from patient_bus import PatientBus

    with PatientBus("beside_the_world", domain_id=world.domain) as made:
        yield made


def controller(bus, group: str, count: int):
    from patient_bus import joints_of

    from grip_bt.ros.controllers import TrajectoryExecutor

    names = tuple(f"panda_joint{i}" for i in range(1, count + 1))
    states = joints_of(bus, names)
    return TrajectoryExecutor(bus, f"/{group}_controller/follow_joint_trajectory", names, states, wait=PATIENCE)


def swing(state: JointState, angle: float, seconds: float) -> Trajectory:
    """Return a smooth turn of the first joint from where it is."""
    times = np.linspace(0.0, seconds, 41)
    part = (1 - np.cos(np.pi * times / seconds)) / 2
    goal = state.position + angle * np.eye(len(state.names))[0]
    return Trajectory(state.names, times, state.position + np.outer(part, goal - state.position))


def moved_from(arm, position: float) -> None:
    """Wait until the first joint is elsewhere."""
    until(lambda: abs(arm.state().position[0] - position) > 0.02, "it doesn't move")


pytestmark = [pytest.mark.ros, pytest.mark.sim, pytest.mark.slow, pytest.mark.timeout(1200)]


def test_a_trajectory_moves_the_simulated_joints(world, bus):
    arm = controller(bus, "right", 7)
    wanted = swing(arm.state(), 0.3, 1.0)
    moving = arm.execute(wanted)
    assert moving.wait(PATIENCE)
    assert moving.result().position == pytest.approx(wanted.positions[-1], abs=0.02)


def test_a_motion_that_is_stopped_ends_where_it_is(world, bus):
    arm = controller(bus, "right", 7)
    before, wanted = arm.state(), swing(arm.state(), -0.8, 40.0)
    moving = arm.execute(wanted)
    moved_from(arm, before.position[0])
    arm.stop()
    assert moving.wait(PATIENCE)
    with pytest.raises(CanceledError):
        moving.result()
    assert 0.01 < abs(arm.state().position[0] - before.position[0]) < 0.79


def test_another_goal_takes_the_place_of_the_one_before(world, bus):
    from control_msgs.action import FollowJointTrajectory
    from trajectory_msgs.msg import JointTrajectoryPoint

    arm = controller(bus, "right", 7)
    start = arm.state()
    first = arm.execute(swing(start, 0.8, 40.0))
    moved_from(arm, start.position[0])
    client = bus.action(FollowJointTrajectory, "/right_controller/follow_joint_trajectory")
    goal = FollowJointTrajectory.Goal()  # one point, a second from now, as people write it
    goal.trajectory.joint_names = list(start.names)
    goal.trajectory.points.append(JointTrajectoryPoint(positions=start.position.tolist()))
    goal.trajectory.points[0].time_from_start.sec = 1
    second = client.send(goal, PATIENCE, PATIENCE)
    assert second.wait(PATIENCE)
    assert second.result().status == "succeeded"
    assert arm.state().position == pytest.approx(start.position, abs=0.03)
    assert first.wait(PATIENCE)


@pytest.mark.parametrize(
    ("names", "times", "positions"),
    [
        (["panda_joint1"], [1.0], [[0.0]]),
        (None, [1.0, 0.5], [[0.0] * 7] * 2),
        (None, [1.0], [[0.0] * 6]),
        (None, [1.0], [[float("nan")] * 7]),
        (None, [], []),
    ],
    ids=["other joints", "times that fall", "too few positions", "not a number", "no points"],
)
def test_what_cannot_be_followed_is_rejected(world, bus, names, times, positions):
    from control_msgs.action import FollowJointTrajectory
    from trajectory_msgs.msg import JointTrajectoryPoint

    goal = FollowJointTrajectory.Goal()
    goal.trajectory.joint_names = names or [f"panda_joint{i}" for i in range(1, 8)]
    for at, row in zip(times, positions, strict=True):
        point = JointTrajectoryPoint(positions=row)
        point.time_from_start.sec, point.time_from_start.nanosec = int(at), int(at % 1 * 1e9)
        goal.trajectory.points.append(point)
    client = bus.action(FollowJointTrajectory, "/right_controller/follow_joint_trajectory")
    sent = client.send(goal, PATIENCE, PATIENCE)
    assert sent.wait(PATIENCE)
    with pytest.raises(GoalRejectedError):
        sent.result()


def test_a_task_runs_on_it_as_on_a_real_robot(world):
    """By what `grip sim` says is to be written: its room, its controllers, its camera."""
    from grip_bt.ros.command import child_environment

    said = world.log.read_text()
    settings = said[said.index("scene:") :].partition("\nserving")[0]
    assert yaml.safe_load(settings)["ros"]["cameras"]["overhead"]["image"] == "/overhead/color/image_raw"
    patient = settings.replace("\nros:\n", "\nros:\n  ready: 400\n  stale: 60\n")
    patient = patient.replace("      mount:", "      timeout: 400\n      mount:")
    assert yaml.safe_load(patient)["ros"]["cameras"]["overhead"]["timeout"] == yaml.safe_load(patient)["ros"]["ready"]
    (world.folder / "grip.yaml").write_text(PROJECT + patient)
    assert "* table" in (world.folder / "room.scene").read_text()
    command = [sys.executable, "-m", "grip_bt.cli", "run", "task.yaml", "--robot", "ros"]
    environment = child_environment((), world.domain)
    done = subprocess.run(
        command, cwd=world.folder, env=environment, capture_output=True, text=True, timeout=2 * PATIENCE
    )
    assert done.returncode == 0, done.stdout + done.stderr + world.log.read_text()
    listed = subprocess.run(
        [sys.executable, "-m", "grip_bt.cli", "runs", "last", "--data", "--json"],
        cwd=world.folder,
        capture_output=True,
        text=True,
    )
    assert "PointCloud" in listed.stdout


def test_the_end_says_where_things_are_and_leaves_nothing(world):
    """Last in this file: it ends the world of the others."""
    os.kill(world.process.pid, signal.SIGINT)
    assert world.process.wait(PATIENCE) == 0
    assert "standing" in world.log.read_text()
