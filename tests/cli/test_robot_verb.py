import json
import subprocess
import sys

import pytest

from grip_bt.cli.__main__ import main

BAD = """<robot name="r">
<link name="base"><collision><geometry><mesh filename="package://nowhere/a.stl"/></geometry></collision></link>
<link name="arm"><collision><geometry><mesh filename="b.stl"/></geometry></collision></link>
<joint name="j" type="revolut"><parent link="base"/><child link="arm"/></joint>
</robot>
"""


@pytest.fixture
def bad(tmp_path):
    path = tmp_path / "bad.urdf"
    path.write_text(BAD)
    return str(path)


def test_check_names_every_missing_mesh_package_and_odd_joint_and_ends_with_1(bad, capsys):
    assert main(["robot", "check", bad]) == 1
    said = capsys.readouterr().out.splitlines()
    assert [line.split("] ")[0].split("[")[1] for line in said[:-1]] == [
        "missing-package",
        "missing-mesh",
        "joint-type",
    ]
    assert said[0].startswith(f"{bad}:2: warning[missing-package] robot: link 'base': mesh 'package://nowhere/a.stl'")
    assert said[-1] == f"{bad}: 1 error, 2 warnings"


def test_check_as_json_has_the_same_findings(bad, capsys):
    assert main(["robot", "check", bad, "--json"]) == 1
    found = json.loads(capsys.readouterr().out)["findings"]
    assert [(f["severity"], f["code"], f["line"]) for f in found] == [
        ("warning", "missing-package", 2),
        ("warning", "missing-mesh", 3),
        ("error", "joint-type", 4),
    ]


def test_check_takes_packages_and_a_mesh_that_is_no_mesh_is_an_error_too(tmp_path, capsys):
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "a.stl").write_text("this is no mesh")
    path = tmp_path / "r.urdf"
    path.write_text(BAD.replace("nowhere", "here").replace("b.stl", "meshes/a.stl").replace("revolut", "fixed"))
    assert main(["robot", "check", str(path), "--package", f"here={tmp_path / 'meshes'}"]) == 1
    assert "error[bad-model] robot: " in capsys.readouterr().out


def test_a_ready_made_robot_is_ok_and_shown_with_groups_limits_states_solvers_and_planners(capsys):
    assert main(["robot", "check", "ur3"]) == 0
    assert capsys.readouterr().out == "ur3: ok\n"
    assert main(["robot", "show", "ur3"]) == 0
    shown = capsys.readouterr().out
    assert "grasp_frames: {arm: tool0}" in shown
    assert "elbow_joint: {type: revolute, lower: -3.14159, upper: 3.14159, velocity: 3.15," in shown
    assert "home: {shoulder_pan_joint: 0.0, shoulder_lift_joint: -1.57, elbow_joint: 1.57," in shown
    assert "solvers: [damped_least_squares, trac_ik]" in shown
    assert "BiTRRT" in shown


def test_show_as_json_and_of_a_wrong_robot(bad, capsys):
    assert main(["robot", "show", "panda", "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["joints"]["panda_finger_joint2"]["follows"] == "panda_finger_joint1"
    assert shown["end_effectors"][-1] == {
        "name": "hand",
        "group": "hand",
        "parent_link": "panda_link8",
        "parent_group": "arm",
    }
    assert main(["robot", "show", bad]) == 1
    assert "joint-type" in capsys.readouterr().err


def test_an_unknown_robot_lists_the_ready_made_ones_and_list_does_so_too(capsys):
    assert main(["robot", "check", "ur4"]) == 1
    assert "unknown robot 'ur4'" in capsys.readouterr().err
    assert main(["robot", "list"]) == 0
    assert {"panda", "ur3", "ur5", "ur10", "xarm7", "allegro_left", "shadow_right"} <= set(
        capsys.readouterr().out.split()
    )


def test_an_option_without_a_value_is_a_usage_error(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["robot", "check", "ur3", "--arg", "prefix"])
    assert ended.value.code == 2
    assert "--arg takes NAME=VALUE, not 'prefix'" in capsys.readouterr().err


def test_a_command_that_has_loaded_a_planner_ends_without_a_word_of_its_library(tmp_path):
    command = [sys.executable, "-m", "grip_bt.cli", "new", str(tmp_path / "lab"), "--robot", "no_such_robot"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1, done.stderr


def test_options_for_files_are_refused_with_a_ready_made_robot(tmp_path, capsys, monkeypatch):
    """Though a folder is called as it is."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "panda").mkdir()
    with pytest.raises(SystemExit) as ended:
        main(["robot", "show", "panda", "--srdf", "x.srdf"])
    assert ended.value.code == 2
    assert "panda is ready-made and takes no srdf; ./panda is a folder" in capsys.readouterr().err
