"""A task on a robot whose controllers run in another process: planned by us, moved by them, measured at the end."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest
from patience import PATIENCE

from grip_bt.task.catalog.ros_config import ControllerConfig, RosRobotConfig

HOME = dict(
    zip(
        (*(f"shoulder_{n}_joint" for n in ("pan", "lift")), "elbow_joint", *(f"wrist_{i}_joint" for i in (1, 2, 3))),
        (-1.4, -1.4, 1.43, -0.03, -0.1, 0.0),
        strict=True,
    )
)
LIMIT = 4 * PATIENCE
PROJECT = """
grip: 1
robot: ur5_allegro
arms: {right: {group: arm, hand: fingers, planning_time: 60}}
hands: {fingers: {group: hand}}
ros:
  ready: 400
  stale: 60
  controllers:
    right: {trajectory: /ur/follow_joint_trajectory, name: arm_controller, instead_of: [stream_controller]}
    fingers: {trajectory: /allegro/follow_joint_trajectory}
"""
TASK = """
grip: 1
name: home
root:
  kind: sequence
  children:
    go: {node: arm/move_to, with: {state: home}}
    open: {node: hand/open}
"""


@pytest.mark.ros
@pytest.mark.slow
def test_a_task_runs_on_controllers_of_another_process(tmp_path, domain, start_server):
    from grip_bt.ros.command import child_environment
    from grip_bt.ros.interfaces.build import ensure_package

    by_topic = PROJECT.replace("trajectory: /allegro/follow_joint_trajectory", "topic: /allegro/joint_trajectory")
    (tmp_path / "grip.yaml").write_text(by_topic)
    (tmp_path / "task.yaml").write_text(TASK)
    prefixes = [*ensure_package("control_msgs"), *ensure_package("controller_manager_msgs")]
    away = {name: angle + 0.1 for name, angle in HOME.items()}
    fingers = {f"hand_joint_{i}.0": 0.0 for i in range(16)} | {"hand_joint_12.0": 1.3}
    start_server("controller_server.py", json.dumps({"ur": away, "allegro": fingers}), overlays=prefixes)
    command = [sys.executable, "-m", "grip_bt.cli", "run", str(tmp_path / "task.yaml"), "--robot", "ros"]
    done = subprocess.run(command, env=child_environment((), domain), capture_output=True, text=True, timeout=LIMIT)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "success" in done.stdout


@pytest.mark.ros
@pytest.mark.slow
def test_where_a_real_robot_is_can_be_kept_from_the_editor(tmp_path, domain, start_server):
    from grip_bt.base.message_store.text import value_of
    from grip_bt.base.values import JointState, Pose
    from grip_bt.commanders.description.load import build_robot
    from grip_bt.commanders.kinematics.model import RobotModel
    from grip_bt.ros.command import child_environment
    from grip_bt.ros.interfaces.build import ensure_package

    (tmp_path / "grip.yaml").write_text(PROJECT)
    prefixes = [*ensure_package("control_msgs"), *ensure_package("controller_manager_msgs")]
    fingers = {f"hand_joint_{i}.0": 0.0 for i in range(16)} | {"hand_joint_12.0": 1.3}
    start_server("controller_server.py", json.dumps({"ur": HOME, "allegro": fingers}), overlays=prefixes)
    found = {}
    for part, what in (("right", "joints"), ("right", "pose"), ("fingers", "joints"), ("fingers", "pose")):
        request = json.dumps({"robot": "ros", "part": part, "what": what})
        command = [sys.executable, "-m", "grip_gui.live.trying"]
        done = subprocess.run(
            command,
            input=request,
            cwd=tmp_path,
            env=child_environment((), domain),
            capture_output=True,
            text=True,
            timeout=LIMIT,
        )
        found[part, what] = json.loads(done.stdout.splitlines()[-1])
    assert value_of("joint_states", "there", found["right", "joints"]["text"]).as_mapping() == pytest.approx(HOME)
    hand = value_of("joint_states", "there", found["fingers", "joints"]["text"]).as_mapping()
    assert hand == pytest.approx(fingers)
    pose = value_of("poses", "there", found["right", "pose"]["text"])
    wanted = RobotModel(build_robot("ur5_allegro")).grasp_pose(JointState.from_mapping(HOME))
    assert isinstance(pose, Pose)
    assert pose.position == pytest.approx(wanted.position, abs=1e-6)
    assert "is a hand" in found["fingers", "pose"]["error"]


def test_a_project_without_controllers_is_told_how_to_name_them(tmp_path):
    (tmp_path / "grip.yaml").write_text(PROJECT[: PROJECT.index("ros:")])
    (tmp_path / "task.yaml").write_text(TASK)
    command = [sys.executable, "-m", "grip_bt.cli", "run", str(tmp_path / "task.yaml"), "--robot", "ros"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT)
    assert done.returncode == 1
    assert "name the controller of each arm and hand in grip.yaml: `ros: {controllers: {" in done.stderr


def test_an_arm_without_a_controller_is_named(tmp_path):
    (tmp_path / "grip.yaml").write_text(PROJECT.replace("    fingers: {trajectory", "    finger: {trajectory"))
    (tmp_path / "task.yaml").write_text(TASK)
    command = [sys.executable, "-m", "grip_bt.cli", "run", str(tmp_path / "task.yaml"), "--robot", "ros"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT)
    assert done.returncode == 1
    assert "unknown controller of 'fingers'; did you mean 'finger'" in done.stderr


@pytest.mark.ros
@pytest.mark.slow
def test_what_a_robot_is_waited_for_is_told_meanwhile(tmp_path, domain):
    """Nobody measures joints: that is said while the run still waits, not only at its end."""
    streamed = PROJECT[: PROJECT.index("  ready:")]
    streamed += (
        "  ready: 8\n  controllers:\n    right: {positions: /arm/commands}\n    fingers: {positions: /f/commands}\n"
    )
    (tmp_path / "grip.yaml").write_text(streamed)
    (tmp_path / "task.yaml").write_text(TASK)
    command = [sys.executable, "-m", "grip_bt.cli", "run", str(tmp_path / "task.yaml"), "--robot", "ros"]
    env = {**os.environ, "ROS_DOMAIN_ID": str(domain)}
    done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT, env=env)
    assert done.returncode == 1
    told = next(line for line in done.stdout.splitlines() + done.stderr.splitlines() if "waiting for it" in line)
    assert "it has no publisher; " in told
    assert told.endswith("; waiting for it, at most 8 s")
    assert "nothing about" in done.stderr


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ({}, "give exactly one of `trajectory`, `topic`, `positions`, `move_group`, `gripper`; here: none of them"),
        ({"trajectory": "/a", "gripper": "/b"}, "here: trajectory and gripper"),
        ({"trajectory": "/a", "instead_of": ["b"]}, "`instead_of` needs the controller's own `name`"),
    ],
)
def test_a_controller_is_reached_in_one_way(given, reason):
    with pytest.raises(ValueError, match=reason):
        ControllerConfig(**given)


def test_a_real_robot_has_controllers():
    with pytest.raises(ValueError, match="name the controller of each arm and hand"):
        RosRobotConfig(controllers={})


MOVEIT_PROJECT = """
grip: 1
robot: ur5_allegro
arms: {right: {group: arm, planner: move_group, planning_time: 60}}
ros:
  ready: 400
  stale: 60
  move_group: {planner: RRTConnectkConfigDefault, wait: 400}
  controllers:
    right: {move_group: /execute_trajectory}
"""


@pytest.mark.ros
@pytest.mark.slow
def test_a_task_is_planned_and_executed_by_move_group(tmp_path, domain, start_server):
    from grip_bt.ros.command import child_environment
    from grip_bt.ros.interfaces.build import ensure_package

    (tmp_path / "task.yaml").write_text(TASK.replace("    open: {node: hand/open}\n", ""))
    start_server("move_group_server.py", "ur5_allegro", overlays=ensure_package("moveit_msgs"))

    def run(project: str) -> subprocess.CompletedProcess[str]:
        (tmp_path / "grip.yaml").write_text(project)
        command = [sys.executable, "-m", "grip_bt.cli", "run", str(tmp_path / "task.yaml"), "--robot", "ros"]
        return subprocess.run(command, env=child_environment((), domain), capture_output=True, text=True, timeout=LIMIT)

    done = run(MOVEIT_PROJECT)
    refused = run(MOVEIT_PROJECT.replace("RRTConnectkConfigDefault", "'fail:-12'"))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "success" in done.stdout
    assert refused.returncode == 3
    assert "goal_in_collision" in refused.stdout + refused.stderr  # which only move_group says of this goal


@pytest.mark.ros
@pytest.mark.sim
@pytest.mark.slow
def test_a_simulated_arm_says_that_move_group_is_not_there(tmp_path, domain):
    from grip_bt.ros.command import child_environment

    text = MOVEIT_PROJECT.replace("ur5_allegro", "panda_allegro").replace("wait: 400", "wait: 0.5")
    (tmp_path / "grip.yaml").write_text(text + "world: table\n")
    (tmp_path / "task.yaml").write_text(TASK.replace("    open: {node: hand/open}\n", ""))
    command = [sys.executable, "-m", "grip_bt.cli", "run", str(tmp_path / "task.yaml"), "--robot", "sim"]
    done = subprocess.run(command, env=child_environment((), domain), capture_output=True, text=True, timeout=LIMIT)
    assert done.returncode == 3, done.stdout + done.stderr
    assert "planner_lost" in done.stdout + done.stderr
    assert "/move_group: the scene" in done.stdout + done.stderr
