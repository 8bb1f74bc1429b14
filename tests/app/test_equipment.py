"""`grip check` tells what a task names and the project's robot hasn't; no robot, ROS or simulator is started for it."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from smally_project import write_project

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.cli.__main__ import main
from grip_bt.task import read_text
from grip_bt.task.validation import validate
from grip_bt.task.validation.fixes import Fixer

EXAMPLES = Path(__file__).parents[2] / "examples"
PROJECT = """grip: 1
robot: panda_allegro
arms: {right: {hand: right_hand}}
hands: {right_hand: {}}
"""
TASK = "grip: 1\nname: demo\nroot: ROOT\n"


@pytest.fixture
def said(tmp_path):
    """Return a function that returns `[code, message]` of the issues of a task in a project."""

    def issues(root: str, project: str = PROJECT) -> list[tuple[str, str]]:
        (tmp_path / "grip.yaml").write_text(project)
        task = read_text(TASK.replace("ROOT", root)).task
        return [(i.code, i.message) for i in validate(task, project_catalog(tmp_path)).issues]

    return issues


@pytest.mark.parametrize(
    ("root", "code", "words"),
    [
        ("{node: arm/move_to, with: {arm: rihgt, state: home}}", "unknown-arm", ["did you mean 'right'"]),
        ("{node: arm/move_to, with: {state: hoem}}", "unknown-state", ["'hoem'", "did you mean 'home'"]),
        ("{node: arm/plan, with: {state: hoem}, out: {}}", "unknown-state", ["available: home"]),
        ("{node: hand/open, with: {hand: left_hand}}", "unknown-hand", ["'left_hand'", "available: right_hand"]),
        ("{node: hand/posture, with: {posture: flatt}}", "unknown-state", ["did you mean 'flat'"]),
        ("{node: hand/fingers, with: {closing: {thum: 0.5}}}", "unknown-finger", ["did you mean 'thumb'"]),
        ("{node: hand/fingertips, with: {tips: {thum: [0, 0, 0]}}}", "unknown-finger", ["did you mean 'thumb'"]),
        ("{node: hand/fingertips, with: {tips: {thumb: [0, 0, 0]}, frame: plam}}", "unknown-link", ["palm"]),
        ("{node: scene/attach, with: {name: box, hand: lef}}", "unknown-hand", ["'lef'"]),
    ],
)
def test_a_name_that_the_robot_has_not_is_told(said, root, code, words):
    ((found, message),) = said(root)
    assert found == code
    for word in words:
        assert word in message


@pytest.mark.parametrize(
    "root",
    [
        "{node: arm/move_to, with: {state: home}}",
        "{node: arm/move_to, with: {arm: right, state: home}}",
        "{node: hand/posture, with: {posture: flat}}",
        "{node: hand/fingers, with: {closing: {thumb: 0.5}}}",
        "{node: hand/fingertips, with: {tips: {thumb: [0, 0, 0], hand_link_0.0: [0, 0, 0]}, frame: hand_palm_link}}",
        "{node: hand/fingertips, with: {tips: {thumb: [0, 0, 0]}, frame: grasp}}",
        "{node: hand/open}",
    ],
)
def test_what_the_robot_has_is_no_issue(said, root):
    assert said(root) == []


@pytest.mark.parametrize(
    ("project", "words"),
    [
        (PROJECT.replace("hand: right_hand}", "planner: RRTConect}"), ["did you mean 'RRTConnect'", "arms/right"]),
        (PROJECT.replace("hand: right_hand}", "kinematics: kdl}"), ["unknown kinematics solver 'kdl'", "trac_ik"]),
        (PROJECT.replace("hand: right_hand}", "group: manipulator}"), ["unknown group 'manipulator'", "arm"]),
        (PROJECT.replace("hand: right_hand}", "hand: claw}"), ["unknown hand 'claw'", "right_hand"]),
        (PROJECT.replace("panda_allegro", "panda_alegro"), ["did you mean 'panda_allegro'"]),
        (
            PROJECT + "ros: {controllers: {rigth: {topic: /a}, right_hand: {topic: /b}}}\n",
            ["unknown controller of 'right'; did you mean 'rigth'?"],
        ),
    ],
)
def test_what_the_project_says_wrongly_of_a_part_is_told_once_to_the_tasks_that_use_it(said, project, words):
    go = "{node: arm/move_to, with: {state: home}}"
    twice = f"{{kind: sequence, children: {{a: {go}, b: {go}}}}}"
    told = [message for code, message in said(twice, project) if code in ("unfit-project", "no-controller")]
    assert len(told) == 1
    for word in words:
        assert word in told[0]
    assert "unfit-project" not in dict(said("{node: pose/make, with: {position: [0, 0, 0]}}", project))


def test_a_sensor_on_no_link_and_messages_that_are_not_installed_are_told(said):
    pytest.importorskip("rclpy")
    sensor = (
        "sensors:\n  wrist:\n    topics: {cloud: {topic: /c, type: camra_msgs/msg/Cloud}}\n"
        "    mount: {frame: optical, on: panda_link88}\n"
    )
    found = dict(said("{node: sensor/wrist}", PROJECT + sensor))
    assert found.keys() >= {"missing-package", "unfit-project"}
    assert "'camra_msgs' isn't installed" in found["missing-package"]
    assert "unknown link 'panda_link88'; did you mean 'panda_link8'?" in found["unfit-project"]
    type_ = "{node: ros/publish, with: {topic: /a, type: geometry_msg/msg/Pose}, in: {}}"
    assert "did you mean 'geometry_msgs'?" in dict(said(type_))["missing-package"]


def test_of_several_arms_one_has_to_be_said(said, tmp_path):
    project = "grip: 1\nrobot: two_ur5_allegro\narms: {left: {group: left_arm}, right: {group: right_arm}}\n"
    ((code, message),) = said("{node: arm/move_to, with: {state: home}}", project)
    assert (code, message) == ("unknown-arm", "the project has several arms (left, right); say which: `arm: ...`")


def test_nothing_is_said_where_nobody_knows(said):
    unknown = "{node: arm/move_to, with: {arm: any, state: anything}}"
    assert said(unknown, "grip: 1\n") == []
    without = PROJECT.replace("robot: panda_allegro\n", "")
    assert said("{node: arm/move_to, with: {state: anything}}", without) == []
    assert [code for code, _ in said(unknown, without)] == ["unknown-arm"]


def test_taught_names_are_known(said, tmp_path):
    move = "{node: arm/move_to, with: {state: above}}"
    assert [code for code, _ in said(move)] == ["unknown-state"]
    joints = ", ".join(f"panda_joint{n}: 0.0" for n in range(1, 8))
    (tmp_path / "taught.yaml").write_text(f"right:\n  above: {{state: {{{joints}}}}}\n")
    assert said(move) == []


def test_a_file_of_the_robot_that_changes_is_read_again(tmp_path):
    task = read_text(write_project(tmp_path).read_text().replace("state: home", "state: parked")).task
    before = validate(task, project_catalog(tmp_path)).issues
    assert ["unknown-state"] == [issue.code for issue in before]
    (srdf,) = tmp_path.glob("src/*/config/*.srdf")
    state = '<group_state name="parked" group="manipulator"><joint name="j1" value="0.1"/></group_state>'
    srdf.write_text(srdf.read_text().replace("</robot>", f"{state}</robot>"))
    assert validate(task, project_catalog(tmp_path)).issues == ()


def test_the_editor_offers_the_nearest_name(tmp_path):
    (tmp_path / "grip.yaml").write_text(PROJECT)
    task = read_text(TASK.replace("ROOT", "{node: arm/move_to, with: {arm: rihgt, state: home}}")).task
    catalog = project_catalog(tmp_path)
    (issue,) = validate(task, catalog).issues
    assert [fix.title for fix in Fixer(task, catalog).fixes(issue)] == ["Use right"]


def test_the_verb_tells_it_as_an_error(tmp_path, capsys):
    (tmp_path / "grip.yaml").write_text(PROJECT)
    file = tmp_path / "task.yaml"
    file.write_text(TASK.replace("ROOT", "{node: arm/move_to, with: {state: hoem}}"))
    assert main(["check", str(file), "--json"]) == 1
    ((issue,),) = [entry["issues"] for entry in json.loads(capsys.readouterr().out)]
    assert (issue["code"], issue["severity"], issue["line"]) == ("unknown-state", "error", 3)
    assert issue["fix"] == "write 'home'"


@pytest.mark.parametrize(
    ("before", "after"),
    [("meaning:", "meanig:"), ("name: antipodal_grasps", "name: [1]"), ("{call: 60", "{call: -6"), ("\n", "\n\t{")],
)
def test_a_component_whose_file_is_broken_is_told_to_the_tasks_that_use_it(tmp_path, capsys, before, after):
    shutil.copytree(EXAMPLES / "components", tmp_path / "components")
    file = tmp_path / "components" / "antipodal_grasps" / "component.yaml"
    text = file.read_text()
    assert before in text
    file.write_text(text.replace(before, after, 1))
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    (tmp_path / "t.yaml").write_text(
        "grip: 1\nname: t\ndata: {c: PointCloud, g: 'list[GraspHypothesis]'}\n"
        "root: {node: component/antipodal_grasps, in: {cloud: c}, out: {grasps: g}}\n"
    )
    main(["check", str(tmp_path / "t.yaml")])
    said = capsys.readouterr()
    assert "components/antipodal_grasps/component.yaml: a run refuses this component: " in said.out + said.err


def test_no_library_of_motion_of_ros_or_of_the_simulator_is_loaded(tmp_path):
    write_project(tmp_path)
    code = (
        "import sys; from grip_bt.app.project.catalogue import project_catalog; "
        "assert project_catalog(sys.argv[1]).parts().arms; "
        "print({'ompl', 'coal', 'pinocchio', 'rclpy', 'sapien', 'py_trees'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
