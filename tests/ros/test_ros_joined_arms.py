"""Two arms with a controller each, moved by one plan: `arms: {both: {arms: [left, right]}}` on a robot over ROS 2."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest
from patience import PATIENCE

ARM = ("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint")
AWAY = (-1.4, -1.4, 1.43, -0.03, -0.1, 0.0)
LIMIT = 4 * PATIENCE
PROJECT = """grip: 1
robot:
  robots:
    left: {robot: ur5, xyz: [0, 0.8, 0]}
    right: {robot: ur5, xyz: [0, -0.8, 0]}
  groups:
    arms: {groups: [left_arm, right_arm]}
arms:
  left: {group: left_arm}
  right: {group: right_arm}
  both: {group: arms, arms: [left, right], planning_time: 60}
ros:
  ready: 400
  stale: 60
  controllers:
    left: {trajectory: /left/follow_joint_trajectory}
    right: {trajectory: /right/follow_joint_trajectory}
"""
TASK = """grip: 1
name: both
data: {left: JointState, right: JointState}
root:
  kind: sequence
  children:
    home: {node: arm/move_to, with: {arm: both, state: home}}
    left: {node: arm/read_state, with: {arm: left}, out: {state: left}}
    right: {node: arm/read_state, with: {arm: right}, out: {state: right}}
    one: {node: flow/log, with: {message: left}, in: {value: left}}
    other: {node: flow/log, with: {message: right}, in: {value: right}}
"""


@pytest.mark.ros
@pytest.mark.slow
def test_one_plan_goes_to_the_controllers_of_both_arms(tmp_path, domain, start_server):
    from grip_bt.commanders.description.load import build_robot
    from grip_bt.ros.command import child_environment
    from grip_bt.ros.interfaces.build import ensure_package
    from grip_bt.runtime import JournalReader

    (tmp_path / "grip.yaml").write_text(PROJECT)
    (tmp_path / "both.yaml").write_text(TASK)
    prefixes = [*ensure_package("control_msgs"), *ensure_package("controller_manager_msgs")]
    sides = {side: {f"{side}_{joint}": at for joint, at in zip(ARM, AWAY, strict=True)} for side in ("left", "right")}
    start_server("controller_server.py", json.dumps(sides), overlays=prefixes)
    command = [sys.executable, "-m", "grip_bt.cli", "run", str(tmp_path / "both.yaml"), "--robot", "ros"]
    done = subprocess.run(command, env=child_environment((), domain), capture_output=True, text=True, timeout=LIMIT)
    assert done.returncode == 0, done.stdout + done.stderr
    home = build_robot("ur5").named_states["arm"]["home"].as_mapping()
    with JournalReader(tmp_path / ".grip" / "runs.sqlite") as reader:
        run = reader.runs()[0].id
        written = reader.variables(run)
        measured = {name: reader.value(written[name]).as_mapping() for name in ("left", "right")}
    for side in ("left", "right"):
        assert measured[side] == pytest.approx({f"{side}_{joint}": at for joint, at in home.items()}, abs=0.02)
