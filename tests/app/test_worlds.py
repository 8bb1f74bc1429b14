"""A world, a camera or a room that isn't there is told by `grip check`, and by a run before anything is started."""

from __future__ import annotations

import pytest

from grip_bt.app.project.catalogue import project_catalog
from grip_bt.cli.__main__ import main
from grip_bt.task import read_text
from grip_bt.task.validation import validate
from grip_sim.worlds import BUILTIN

PROJECT = """grip: 1
robot: panda_allegro
arms: {right: {hand: right_hand}}
hands: {right_hand: {}}
sensors: {overhead: {camera: CAMERA}}
world: WORLD
"""
WORLDS = ", ".join(BUILTIN)
NO_WORLD = f"grip.yaml: world: which world? None is named (available: {WORLDS})"
GO, LOOK = "{node: arm/move_to, with: {state: home}}", "{node: sensor/overhead}"
UNKNOWN_WORLD = f"grip.yaml: world: unknown world 'tabel'; did you mean 'table'? (available: {WORLDS})"
UNKNOWN_CAMERA = (
    "grip.yaml: sensors/overhead/camera, world 'table': unknown camera 'overhed'; did you mean 'overhead'? "
    "(available: overhead)"
)


def project(world: str = "table", camera: str = "overhead") -> str:
    return PROJECT.replace("WORLD", world).replace("CAMERA", camera)


@pytest.fixture
def said(tmp_path):
    """Return a function that returns the messages about a project, of a task with one node."""

    def messages(root: str, text: str) -> list[str]:
        (tmp_path / "grip.yaml").write_text(text)
        task = read_text(f"grip: 1\nname: demo\nroot: {root}\n").task
        issues = validate(task, project_catalog(tmp_path)).issues
        assert {issue.code for issue in issues} <= {"unfit-project", "unused-outcome"}, issues
        return [issue.message for issue in issues if issue.code == "unfit-project"]

    return messages


def test_an_unknown_world_is_told_to_whatever_is_simulated_and_once(said):
    wrong = project(world="tabel")
    assert said(GO, wrong) == [UNKNOWN_WORLD]
    assert said("{node: hand/open}", wrong) == [UNKNOWN_WORLD]
    assert said(LOOK, wrong) == [UNKNOWN_WORLD]
    assert said(f"{{kind: sequence, children: {{a: {GO}, b: {LOOK}}}}}", wrong) == [UNKNOWN_WORLD]
    assert said("{node: pose/make, with: {position: [0, 0, 0]}}", wrong) == []


def test_a_camera_that_the_world_has_not_is_told_to_those_who_look(said):
    wrong = project(camera="overhed")
    assert said(LOOK, wrong) == [UNKNOWN_CAMERA]
    assert said(GO, wrong) == []


def test_what_is_there_is_no_issue_and_without_a_world_nobody_knows_its_cameras(said):
    assert said(f"{{kind: sequence, children: {{a: {GO}, b: {LOOK}}}}}", project()) == []
    assert said(LOOK, project(camera="wrist").replace("world: WORLD", "").replace("world: table\n", "")) == []


def test_a_file_of_the_room_that_is_wrong_is_told_until_it_is_mended(said, tmp_path):
    text = project() + "scene: room.scene\n"
    (missing,) = said(GO, text)
    assert missing == f"{tmp_path}/room.scene: can't be read: No such file or directory"
    (tmp_path / "room.scene").write_text("(noname)+\n* ball\n1\nsphre\n")
    (wrong,) = said(GO, text)
    assert "room.scene:4" in wrong
    assert "did you mean 'sphere'" in wrong
    (tmp_path / "room.scene").write_text("(noname)+\n.\n")
    assert said(GO, text) == []


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (project(world="tabel"), UNKNOWN_WORLD),
        (project(camera="overhed"), UNKNOWN_CAMERA),
        (
            project().replace("world: table\n", ""),
            f"grip.yaml: world: which world? None is named (available: {WORLDS})",
        ),
        (project() + "scene: room.scene\n", "room.scene: can't be read: No such file or directory"),
    ],
)
def test_a_run_tells_it_before_anything_is_started(tmp_path, capsys, text, message):
    (tmp_path / "grip.yaml").write_text(text)
    (tmp_path / "task.yaml").write_text(f"grip: 1\nname: demo\nroot: {GO}\n")
    assert main(["run", str(tmp_path / "task.yaml"), "--robot", "sim", "--in-process"]) == 1
    said = capsys.readouterr().err
    assert message in said
    assert "starting:" not in said


def test_a_served_world_has_to_have_the_cameras_too(tmp_path, capsys):
    (tmp_path / "grip.yaml").write_text(project(camera="overhed").replace("world: table\n", ""))
    assert main(["sim", "table", "--project", str(tmp_path)]) == 1
    assert UNKNOWN_CAMERA in capsys.readouterr().err
