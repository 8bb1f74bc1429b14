"""What a project's arms name and isn't there is told before a run begins, with what is allowed."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from grip_bt.app.project.folder import find_project
from grip_bt.app.wiring import open as wiring
from grip_bt.app.wiring.parts import Opening
from grip_bt.base.errors import MissingPartError
from grip_bt.cli.__main__ import main

PROJECT = "grip: 1\nrobot: panda_allegro\narms: {right: {FIELDS}}\nhands: {right_hand: {HAND}}\nworld: table\n"
CONTROLLERS = "ros:\n  controllers:\n    right: {trajectory: /a}\n    right_hand: {trajectory: /b}\n"
TASK = "grip: 1\nname: home\nroot: {node: arm/move_to, with: {state: home}}\n"


@pytest.mark.parametrize("robot", ["sim", pytest.param("ros", marks=pytest.mark.ros)])
@pytest.mark.parametrize(
    ("fields", "hand", "words"),
    [
        ("planner: RRTConect", "", ["unknown planner 'RRTConect'", "did you mean 'RRTConnect'", "arms/right"]),
        ("planner: CHOMP", "", ["unknown planner 'CHOMP'", "BiTRRT", "RRTstar", "move_group"]),
        ("kinematics: kdl", "", ["unknown kinematics solver 'kdl'", "trac_ik", "arms/right"]),
        ("group: manipulator", "", ["unknown group 'manipulator'", "arm", "arms/right/group"]),
        ("hand: left_hand", "", ["unknown hand 'left_hand'", "right_hand", "arms/right/hand"]),
        ("hand: right_hand", "group: gripper", ["unknown group 'gripper'", "hand", "hands/right_hand/group"]),
    ],
)
def test_it_is_told_before_anything_is_started(tmp_path, capsys, robot, fields, hand, words):
    text = PROJECT.replace("FIELDS", fields).replace("HAND", hand)
    (tmp_path / "grip.yaml").write_text(text + (CONTROLLERS if robot == "ros" else ""))
    (tmp_path / "home.yaml").write_text(TASK)
    assert main(["run", str(tmp_path / "home.yaml"), "--robot", robot, "--in-process"]) == 1
    said = capsys.readouterr()
    for word in words:
        assert word in said.err, said
    assert "planner:" not in said.err  # the process that plans wasn't begun


def test_ros_is_missed_before_a_simulator_is_started(tmp_path, monkeypatch):
    def load_part(module, what, extra):
        if module == "ros":
            raise MissingPartError(what, f"pip install 'grip-bt[{extra}]'")
        return SimpleNamespace(open_simulated=lambda *_: pytest.fail("it was started"))

    monkeypatch.setattr(wiring, "load_part", load_part)
    (tmp_path / "grip.yaml").write_text("grip: 1\nrobot: panda_allegro\nworld: table\n")
    needs = ["arm/move_to", "component/propose"]
    with (
        pytest.raises(MissingPartError, match="ROS"),
        wiring.open_resources(Opening(find_project(tmp_path)), needs, "sim"),
    ):
        pytest.fail("it was opened")
