"""A task that goes through way points, run by `grip run` over fakes and in simulation."""

from __future__ import annotations

import json

import numpy as np
import pytest

from grip_bt.base.values import JointState
from grip_bt.cli.__main__ import main
from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.runtime import JournalReader

PROJECT = "grip: 1\nrobot: panda_allegro\narms: {right: {hand: right_hand}}\nhands: {right_hand: {}}\nworld: table\n"
TASK = """grip: 1
name: around
data: {before: Pose, after: Pose, plan: Plan, planned: "list[float]", moved: "list[float]", reached: JointState}
root:
  kind: sequence
  children:
    home: {node: arm/move_to, with: {state: home}}
    before: {node: arm/read_pose, out: {pose: before}}
    plan:
      node: arm/plan_through
      with: {offsets: [[0.0, 0.12, 0.0], [0.0, 0.12, 0.1], [0.0, 0.0, 0.1]], radius: 0.03}
      out: {plan: plan, radii: planned}
    go: {node: arm/execute, in: {plan: plan}}
    back:
      node: arm/move_through
      with: {offsets: [[0.0, 0.12, 0.0], [0.0, 0.12, -0.1], [0.0, 0.0, -0.1]], radii: [0.04, 0.0]}
      out: {reached: reached, radii: moved}
    after: {node: arm/read_pose, out: {pose: after}}
"""


@pytest.mark.parametrize("robot", ["fake", pytest.param("sim", marks=[pytest.mark.sim, pytest.mark.slow])])
def test_a_task_goes_round_its_corners(tmp_path, capsys, robot):
    (tmp_path / "grip.yaml").write_text(PROJECT)
    (tmp_path / "around.yaml").write_text(TASK)
    journal = tmp_path / "j.sqlite"
    status = main(["run", str(tmp_path / "around.yaml"), "--robot", robot, "--journal", str(journal), "--json"])
    said = json.loads(capsys.readouterr().out)
    assert (status, said["status"]) == (0, "success"), said
    with JournalReader(journal) as reader:
        run = reader.runs()[0].id
        written = {name: reader.value(event) for name, event in reader.variables(run).items()}
    assert written["after"].position == pytest.approx(written["before"].position, abs=0.02)
    if robot == "fake":
        assert written["planned"] == written["moved"] == [0.0, 0.0]
        return
    assert written["planned"] == pytest.approx([0.03, 0.03])
    assert written["moved"] == [pytest.approx(0.04), 0.0]
    model, trajectory = RobotModel(build_robot("panda_allegro")), written["plan"].trajectory
    way = np.stack([model.grasp_pose(JointState(trajectory.names, row)).position for row in trajectory.positions])
    for offset in ([0.0, 0.12, 0.0], [0.0, 0.12, 0.1]):
        away = np.linalg.norm(way - written["before"].moved(offset).position, axis=1)
        assert 0.005 < away.min() < 0.03
        assert np.abs(trajectory.velocities[away.argmin()]).max() > 0.05
