"""Tasks whose motions keep to something on the way, run by `grip run` over fakes and in simulation."""

from __future__ import annotations

import json

import pytest

from grip_bt.base.values import JointState
from grip_bt.cli.__main__ import main
from grip_bt.commanders.description.load import build_robot
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.commanders.planning.paths import CONSTRAINT_SLACK
from grip_bt.runtime import JournalReader

PROJECT = "grip: 1\nrobot: panda_allegro\narms: {right: {hand: right_hand}}\nhands: {right_hand: {}}\nworld: table\n"
TASK = """grip: 1
name: cup
data: {before: Pose, aside: Pose, plan: Plan, level: PathConstraint}
root:
  kind: sequence
  children:
    home: {node: arm/move_to, with: {state: home}}
    where: {node: arm/read_pose, out: {pose: before}}
    aside:
      node: pose/offset
      with: {position: [0.1, 0.35, -0.05], quaternion: UPRIGHT_TURN}
      in: {pose: before}
      out: {moved: aside}
    level:
      node: arm/constraint
      with: {keep: {orientation: now, tolerance: [0.15, 0.15, free]}}
      out: {constraint: level}
    plan: {node: arm/plan, in: {goal: aside, constraint: level}, out: {plan: plan}}
    go: {node: arm/execute, in: {plan: plan}}
    back: {node: arm/move_to_pose, with: {keep: {orientation: now, tolerance: [0.2, 0.2, free]}}, in: {pose: before}}
    narrow:
      kind: invert
      child:
        off:
          node: arm/move_to
          with: {state: home, keep: {box: {position: [0, 0, 2], size: [0.1, 0.1, 0.1]}}}
"""

UPRIGHT_TURN = {"fake": "[0.9239, 0.0, 0.0, 0.3827]", "sim": "[0.9239, 0.0, 0.3827, 0.0]"}
"""By 45 degrees about the vertical, which is the y axis of the Allegro's grasp frame at home."""


@pytest.mark.parametrize("robot", ["fake", pytest.param("sim", marks=[pytest.mark.sim, pytest.mark.slow])])
def test_a_task_keeps_its_cup_upright(tmp_path, capsys, robot):
    (tmp_path / "grip.yaml").write_text(PROJECT)
    (tmp_path / "cup.yaml").write_text(TASK.replace("UPRIGHT_TURN", UPRIGHT_TURN[robot]))
    journal = tmp_path / "j.sqlite"
    status = main(["run", str(tmp_path / "cup.yaml"), "--robot", robot, "--journal", str(journal), "--json"])
    said = json.loads(capsys.readouterr().out)
    assert (status, said["status"]) == (0, "success"), said
    with JournalReader(journal) as reader:
        run = reader.runs()[0].id
        events = list(reader.events(run))
        assert [e.code for e in events if e.path == "narrow/off" and e.event == "exit"] == ["constraint_broken"]
        written = {name: reader.value(event) for name, event in reader.variables(run).items()}
    if robot == "sim":
        level, trajectory = written["level"], written["plan"].trajectory
        model = RobotModel(build_robot("panda_allegro"))
        way = [model.grasp_pose(JointState(trajectory.names, row), group="arm") for row in trajectory.positions]
        assert all(level.kept_by(pose, CONSTRAINT_SLACK) for pose in way)
        assert way[-1].position - way[0].position == pytest.approx([0.1, 0.35, -0.05], abs=0.01)
