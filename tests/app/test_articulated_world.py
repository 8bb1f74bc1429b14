"""An arm with a gripper opens a drawer and rings a bell by tasks of a few lines; the referee says so."""

import pytest
from trial_project import grip, result_of

pytestmark = [pytest.mark.sim, pytest.mark.slow]
PROJECT = """grip: 1
robot: panda
world: lab_bench
arms: {arm: {group: arm, hand: hand}}
hands: {hand: {group: hand}}
goals: {open_drawer: cabinet_opened > 0.1, ring: bell_presses == 1}
"""
OPEN = """grip: 1
name: open_drawer
data: {before: {type: Pose, value: {position: [0.50, 0.0, 0.24], quaternion: [0.5, 0.5, 0.5, 0.5]}}}
root:
  kind: sequence
  children:
    open: {node: hand/open}
    before: {node: arm/move_to_pose, in: {pose: before}}
    reach: {node: arm/move_straight, with: {offset: [0.127, 0.0, 0.0]}}
    take: {node: hand/close, with: {force: 15.0}}
    pull: {node: arm/move_straight, with: {offset: [-0.14, 0.0, 0.0]}}
    release: {node: hand/open}
"""
RING = """grip: 1
name: ring
data: {above: {type: Pose, value: {position: [0.44, -0.06, 0.12], quaternion: [0.0, 1.0, 0.0, 0.0]}}}
root:
  kind: sequence
  children:
    fist: {node: hand/posture, with: {posture: closed}}
    above: {node: arm/move_to_pose, in: {pose: above}}
    press: {kind: force, as: success, child: {down: {node: arm/move_straight, with: {offset: [0.0, 0.0, -0.089]}}}}
    up: {node: arm/move_straight, with: {offset: [0.0, 0.0, 0.08]}}
"""


@pytest.mark.parametrize(("task", "form", "judged"), [(OPEN, "bt", "opened"), (RING, "sm", "rang")])
def test_what_a_task_does_to_it_is_what_the_referee_says(tmp_path, task, form, judged):
    (tmp_path / "grip.yaml").write_text(PROJECT)
    (tmp_path / "task.yaml").write_text(task)
    done = grip("run", str(tmp_path / "task.yaml"), "--as", form, "--json")
    assert done.returncode == 0, done.stdout + done.stderr
    said = result_of(done)
    assert said["status"] == "success"
    assert said["judged"][judged] is True
