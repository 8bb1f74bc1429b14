"""Fakes have the joints, fingers and postures of the project's robot, so that a task for it runs without simulation."""

import pytest

from grip_bt.app.runs.execute import run
from grip_bt.base.errors import DocumentError

HANDS = "hands: {right_hand: {group: hand}}\narms: {right: {group: arm, hand: right_hand}}\n"

TASK = """
grip: 1
name: t
data: {there: JointState, now: JointState, way: Trajectory}
root:
  kind: sequence
  children:
    stored: {node: messages/get, with: {store: joint_states, name: there}, out: {value: there}}
    go: {node: arm/move_to_joints, in: {state: there}, out: {reached: now}}
    way: {node: messages/get, with: {store: trajectories, name: along}, out: {value: way}}
    along: {node: arm/execute_trajectory, in: {trajectory: way}}
    close: {node: hand/close}
    part: {node: hand/fingers, with: {closing: {FINGER: 0.5}}}
    open: {node: hand/open}
"""


@pytest.mark.parametrize(
    ("robot", "joint", "finger"),
    [("panda_allegro", "panda_joint1", "index"), ("panda", "panda_joint1", "left"), ("ur5_gripper", None, "left")],
)
def test_a_task_of_a_robots_own_joints_and_fingers_runs_over_fakes(tmp_path, robot, joint, finger):
    joint = joint or "shoulder_pan_joint"
    (tmp_path / "grip.yaml").write_text(f"grip: 1\nrobot: {robot}\n{HANDS}")
    (tmp_path / "messages").mkdir()
    (tmp_path / "messages" / "joint_states.yaml").write_text(f"there: {{{joint}: 0.5}}\n")
    way = "along: [{name: there, interpolate_time: 1.0, pause_time: 0.0}]\n"
    (tmp_path / "messages" / "trajectories.yaml").write_text(way)
    task = tmp_path / "t.yaml"
    task.write_text(TASK.replace("FINGER", finger))
    result = run(task, robot="fake")
    assert (result.outcome, result.failure) == ("success", None)


PINCH = """
grip: 1
name: t
root:
  kind: sequence
  children:
    close: {node: hand/close}
    part: {node: hand/fingers, with: {closing: {thumb: 0.5}}}
"""


def test_before_there_is_a_robot_a_hand_has_two_fingers(tmp_path):
    (tmp_path / "grip.yaml").write_text(f"grip: 1\n{HANDS}")
    task = tmp_path / "t.yaml"
    task.write_text(PINCH)
    result = run(task, robot="fake")
    assert (result.outcome, result.failure) == ("success", None)


@pytest.mark.parametrize("robot", ["sim", "ros"])
def test_where_a_robot_is_needed_and_none_is_named_it_says_how_to_name_one(tmp_path, robot):
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    task = tmp_path / "t.yaml"
    task.write_text(PINCH)
    with pytest.raises(DocumentError, match="grip.yaml.*there is no `robot:`.*grip robot list.*--robot fake"):
        run(task, robot=robot)


def test_a_project_without_hands_says_so(tmp_path):
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    task = tmp_path / "t.yaml"
    task.write_text(PINCH)
    told = str(run(task, robot="fake").error)
    assert "a hand isn't available here. Fix: name one under `hands` in grip.yaml" in told
