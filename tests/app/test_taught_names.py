"""`grip check` knows what was taught, what a task teaches itself, and which other task teaches a name."""

from __future__ import annotations

import pytest

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.cli.__main__ import main
from grip_bt.task import read_text
from grip_bt.task.validation import SEVERITY, validate
from grip_bt.task.validation.fixes import Fixer

PROJECT = "grip: 1\nrobot: panda_allegro\narms: {right: {hand: right_hand}}\nhands: {right_hand: {}}\n"
TWO_ARMS = "grip: 1\nrobot: two_ur5_allegro\narms: {left: {group: left_arm}, right: {group: right_arm}}\n"
TEACH, TEACH_HAND = "{node: arm/teach, with: {name: above}}", "{node: hand/teach, with: {name: pinch}}"
TEACH_POSE = "{node: arm/teach, with: {name: above, pose: true}}"
MOVE, GO = "{node: arm/move_to, with: {state: above}}", "{node: arm/move_to_taught, with: {name: above}}"
PINCH = "{node: hand/posture, with: {posture: pinch}}"
JOINTS = ", ".join(f"panda_joint{n}: 0.0" for n in range(1, 8))


def task(*nodes: str) -> str:
    children = ", ".join(f"n{k}: {node}" for k, node in enumerate(nodes))
    return f"grip: 1\nname: demo\nroot: {{kind: sequence, children: {{{children}}}}}\n"


@pytest.fixture
def said(tmp_path):
    """Return a function that returns (code, message, fix) of each issue of a task in a project."""
    (tmp_path / "grip.yaml").write_text(PROJECT)
    (tmp_path / "tasks").mkdir()

    def issues(*nodes: str) -> list[tuple[str, str, str]]:
        document = read_text(task(*nodes), "demo.yaml")
        found = validate(document.task, project_catalog(tmp_path), document).issues
        assert all(issue.severity == SEVERITY[issue.code] for issue in found)
        return [(issue.code, issue.message, issue.fix) for issue in found]

    return issues


@pytest.mark.parametrize(
    ("teach", "use", "message"),
    [
        (TEACH, MOVE, "'above' hasn't been taught to right yet; tasks/learn.yaml teaches it"),
        (TEACH, GO, "'above' hasn't been taught to right yet; tasks/learn.yaml teaches it"),
        (TEACH_POSE, GO, "'above' hasn't been taught to right yet; tasks/learn.yaml teaches it"),
        (TEACH_HAND, PINCH, "'pinch' hasn't been taught to right_hand yet; tasks/learn.yaml teaches it"),
    ],
)
def test_a_name_that_another_task_teaches_is_told_with_that_task(said, tmp_path, teach, use, message):
    (tmp_path / "tasks/learn.yaml").write_text(task(teach))
    assert said(use) == [("not-taught-yet", message, "run tasks/learn.yaml first")]


def test_several_tasks_that_teach_it_are_all_named(said, tmp_path):
    for name in ("again", "learn"):
        (tmp_path / f"tasks/{name}.yaml").write_text(task(TEACH))
    (tmp_path / "tasks/broken.yaml").write_text("root: {node: arm/teach")  # its own check tells what is wrong with it
    ((code, message, fix),) = said(GO)
    assert (code, fix) == ("not-taught-yet", "run tasks/again.yaml first")
    assert message.endswith("yet; tasks/again.yaml, tasks/learn.yaml teach it")


@pytest.mark.parametrize(("teach", "use"), [(TEACH, GO), (TEACH_POSE, GO), (TEACH_HAND, PINCH)])
def test_what_the_task_teaches_itself_is_there_when_it_is_looked_up(said, tmp_path, teach, use):
    assert said(teach, use) == []
    (tmp_path / "tasks/learn.yaml").write_text(task(teach))
    (tmp_path / "tasks/more.yaml").write_text(task("{kind: subtask, task: tasks/learn.yaml}"))
    assert said("{kind: subtask, task: tasks/more.yaml}", use) == []


def test_a_state_that_is_taught_only_meanwhile_comes_too_late_for_a_look_before_the_run(said, tmp_path, capsys):
    ((code, message, fix),) = said(TEACH, MOVE)
    assert code == "not-taught-yet"
    assert message == "'above' is taught only while this task runs, and named states are looked up before it begins"
    assert fix == "go there by `arm/move_to_taught`, or teach it by another task first"
    (tmp_path / "demo.yaml").write_text(task(TEACH, MOVE))
    assert main(["run", str(tmp_path / "demo.yaml"), "--robot", "fake", "--in-process"]) == 4
    assert "unknown named state 'above'" in "".join(capsys.readouterr())
    (tmp_path / "demo.yaml").write_text(task(TEACH, GO))
    assert main(["run", str(tmp_path / "demo.yaml"), "--robot", "fake", "--in-process"]) == 0


@pytest.mark.parametrize("use", [MOVE, GO])
def test_what_was_taught_is_known(said, tmp_path, use):
    (tmp_path / "tasks/learn.yaml").write_text(task(TEACH))
    (tmp_path / "taught.yaml").write_text(f"right:\n  above: {{state: {{{JOINTS}}}}}\n")
    assert said(use) == []


def test_a_pose_is_no_named_state(said, tmp_path):
    (tmp_path / "taught.yaml").write_text("right:\n  above: {pose: {position: [0.5, 0, 0.4]}}\n")
    ((code, message, fix),) = said(MOVE)
    assert (code, fix) == ("unknown-state", "go there by `arm/move_to_taught`")
    assert message.startswith("there is no named state 'above'")
    assert said(GO) == []


def test_a_name_that_nobody_teaches_is_told(said, tmp_path):
    nothing = "there is no taught state or pose 'above' (available: none)"
    assert said(GO) == [("unknown-state", nothing, "teach it first: `grip teach above --arm right`")]
    home = said("{node: arm/move_to_taught, with: {name: home}}")
    assert [fix for _, _, fix in home] == ["it is a named state: go there by `arm/move_to`"]
    (tmp_path / "taught.yaml").write_text(f"right:\n  abvoe: {{state: {{{JOINTS}}}}}\n")
    ((_, message, fix),) = said(GO)
    assert (message.partition(";")[2], fix) == (" did you mean 'abvoe'? (available: abvoe)", "write 'abvoe'")
    catalog = project_catalog(tmp_path)
    document = read_text(task(GO))
    (issue,) = validate(document.task, catalog, document).issues
    assert [found.title for found in Fixer(document.task, catalog).fixes(issue)] == ["Use abvoe"]


def test_what_is_taught_to_one_arm_is_not_known_to_the_other(said, tmp_path):
    (tmp_path / "grip.yaml").write_text(TWO_ARMS)
    left, right = (TEACH.replace("{name", f"{{arm: {arm}, name") for arm in ("left", "right"))
    go = GO.replace("{name", "{arm: right, name")
    assert said(right, go) == []
    assert [code for code, _, _ in said(left, go)] == ["unknown-state"]
    (tmp_path / "tasks/learn.yaml").write_text(task(left))
    assert [code for code, _, _ in said(go)] == ["unknown-state"]


def test_a_file_of_taught_names_that_is_wrong_is_told_and_its_names_are_not_called_unknown(said, tmp_path):
    (tmp_path / "taught.yaml").write_text("right:\n  above: {state: 3}\n")
    ((code, message, _),) = said(MOVE, GO)
    assert code == "unfit-project"
    assert message.startswith(f"{tmp_path}/taught.yaml:2:")
