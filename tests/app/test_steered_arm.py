"""Following and jogging as tasks over the simulator: the arm moves on and on, and stands still in the end."""

from __future__ import annotations

import pytest

from grip_bt.app.runs.execute import RunOptions, open_session
from grip_sim.simulation import SimExecutor

PROJECT = """grip: 1
robot: panda_allegro
arms: {right: {hand: right_hand}}
hands: {right_hand: {}}
world: table
"""
FOLLOW = """grip: 1
name: follow
data: {pose: Pose, target: Pose}
root:
  kind: sequence
  children:
    where: {node: arm/read_pose, out: {pose: pose}}
    aside: {node: pose/offset, with: {position: [0.0, 0.25, 0.0]}, in: {pose: pose}, out: {moved: target}}
    follow: {node: arm/follow, with: {speed: 0.2}, in: {pose: target}}
    hold: {node: arm/hold, with: {seconds: 0.3}}
"""
JOG = """grip: 1
name: jog
root:
  kind: sequence
  children:
    jog:
      kind: invert
      child:
        limit:
          kind: timeout
          seconds: 2.0
          child:
            aside: {node: arm/jog, with: {linear: [0.0, 0.1, 0.0], seconds: null}}
    hold: {node: arm/hold, with: {seconds: 0.3}}
"""


@pytest.fixture
def motions(monkeypatch):
    """What the executor was asked: the motions that began from rest, and those that were gone on with."""
    begun, amended = [], []
    execute, amend = SimExecutor.execute_steered, SimExecutor.amend

    def noted(self, trajectory):
        begun.append(trajectory)
        return execute(self, trajectory)

    def gone_on(self, tail, at):
        done = amend(self, tail, at)
        amended.append(done)
        return done

    monkeypatch.setattr(SimExecutor, "execute_steered", noted)
    monkeypatch.setattr(SimExecutor, "amend", gone_on)
    return begun, amended


@pytest.mark.sim
@pytest.mark.parametrize(("text", "way"), [(FOLLOW, (0.23, 0.27)), (JOG, (0.1, 0.3))], ids=["follow", "jog"])
def test_a_steered_arm_goes_on_in_simulation(tmp_path, motions, text, way):
    (tmp_path / "grip.yaml").write_text(PROJECT)
    task = tmp_path / "task.yaml"
    task.write_text(text)
    with open_session(task, RunOptions(robot="sim", journal=tmp_path / "j.sqlite")) as session:
        arm = session.resources.arms["right"]
        before = arm.grasp_pose()
        result = session.runner.run()
        assert (result.status, result.failure) == ("success", None), result.failure
        gone = arm.grasp_pose().position - before.position
    assert way[0] < gone[1] < way[1]
    assert gone[[0, 2]] == pytest.approx([0.0, 0.0], abs=0.02)
    begun, amended = motions
    assert begun
    assert sum(amended) >= 3
