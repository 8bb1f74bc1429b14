"""`grip teach`: what it writes is what tasks find."""

import json

import pytest

from grip_bt.base.values import JointState, Pose
from grip_bt.cli.__main__ import main
from grip_bt.commanders.taught import TaughtStates

PROJECT = "grip: 1\nrobot: panda_allegro\narms: {right: {hand: right_hand}}\nhands: {right_hand: {}}\nworld: table\n"


@pytest.fixture
def project(tmp_path):
    (tmp_path / "grip.yaml").write_text(PROJECT)
    return tmp_path


def test_without_a_name_it_lists_what_was_taught(project, capsys):
    assert main(["teach", "--project", str(project)]) == 0
    assert "nothing was taught yet" in capsys.readouterr().out
    taught = TaughtStates(project / "taught.yaml")
    taught.put("right", "above", JointState(("a",), [0.25]), {})
    taught.put("right", "look", Pose((1, 2, 3)), {})
    assert main(["teach", "--project", str(project)]) == 0
    assert capsys.readouterr().out.splitlines()[0] == "right/above: a 0.2500"
    assert main(["teach", "--project", str(project), "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert [(entry["part"], entry["name"]) for entry in listed] == [("right", "above"), ("right", "look")]
    assert listed[0]["state"] == {"a": 0.25}


def test_a_project_without_a_robot_and_a_wrong_file_say_what_to_do(tmp_path, capsys):
    assert main(["teach", "here", "--project", str(tmp_path)]) == 1
    assert "`robot:`" in capsys.readouterr().err
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    (tmp_path / "taught.yaml").write_text("right: 3\n")
    assert main(["teach", "--project", str(tmp_path)]) == 1
    assert "taught.yaml:1" in capsys.readouterr().err


@pytest.mark.sim
@pytest.mark.slow
def test_it_remembers_where_the_robot_is(project, capsys):
    sim = ["--robot", "sim", "--project", str(project)]
    assert main(["teach", "start", *sim]) == 0
    assert main(["teach", "loose", "--hand", "right_hand", *sim]) == 0
    taught = TaughtStates(project / "taught.yaml")
    assert set(taught.states("right")) == {"start"}
    assert set(taught.states("right_hand")) == {"loose"}
    assert main(["teach", "home", *sim]) == 1
    assert "name_taken" in capsys.readouterr().err
