import json
import shutil
from pathlib import Path

import pytest

DATA = Path(__file__).parents[1] / "formats" / "smach" / "data"


@pytest.fixture
def grip(typed):
    return typed


@pytest.fixture
def legacy(tmp_path):
    def copy(name):
        target = tmp_path / Path(name).name
        shutil.copy(DATA / name, target)
        return target

    return copy


def test_an_imported_machine_is_checked_and_run_by_the_usual_verbs(grip, legacy, tmp_path):
    task = tmp_path / "out" / "pick.yaml"
    done = grip("import", legacy("pick_mug.py"), "--from", "smach", "--execute", "-o", task)
    assert (done.returncode, done.stdout.split("\n")[0]) == (0, "pick_mug.py: 1 exact")
    assert grip("check", task).returncode == 0
    for target in ("bt", "sm"):
        ran = grip("run", task, "--as", target, "--robot", "fake", "--json")
        assert (ran.returncode, json.loads(ran.stdout)["outcome"]) == (0, "succeeded")


def test_a_folder_is_imported_file_by_file_and_what_failed_is_the_exit_status(grip, legacy, tmp_path):
    for name in ("loops.py", "py2_counter.py", "dynamic_goals.py"):
        legacy(name)
    done = grip("import", tmp_path, "--from", "smach", "--execute", "-o", tmp_path / "tasks")
    assert done.returncode == 1
    assert "py2_counter.py (Python 2): 1 exact" in done.stdout
    assert "warning[incomplete] StateMachine: goes by `ROS parameter ~points`, known only in a run" in done.stdout
    written = sorted(p.name for p in (tmp_path / "tasks").glob("*.yaml"))
    assert written == ["loops_create_patrol.yaml", "py2_counter_create.yaml"]
    assert grip("run", tmp_path / "tasks" / "py2_counter_create.yaml", "--robot", "fake").returncode == 0


def test_without_output_nothing_is_written(grip, legacy, tmp_path):
    file = legacy("loops.py")
    assert grip("import", file, "--from", "smach", "--execute").returncode == 0
    assert list(tmp_path.iterdir()) == [file]


def test_a_file_of_a_person_is_not_overwritten(grip, legacy, tmp_path):
    task = tmp_path / "task.yaml"
    task.write_text("mine")
    done = grip("import", legacy("loops.py"), "--from", "smach", "--execute", "-o", task)
    assert done.returncode == 1
    assert "would be overwritten" in done.stderr
    assert task.read_text() == "mine"
    assert not (tmp_path / "nodes").exists()


def test_execution_is_asked_for_and_takes_arguments_from_a_file(grip, legacy, tmp_path):
    file, given = legacy("executed/given_rooms.py"), tmp_path / "given.json"
    given.write_text(json.dumps({"CleanAll": {"rooms": ["bath", "attic"]}}))
    assert "1 partial" in grip("import", file, "--from", "smach").stdout
    task = tmp_path / "clean.yaml"
    assert grip("import", file, "--from", "smach", "--execute", "--arguments", given, "-o", task).returncode == 0
    assert grip("run", task, "--robot", "fake").returncode == 0


@pytest.mark.parametrize(
    ("arguments", "status", "words"),
    [
        (("nowhere.py", "--from", "smach"), 1, "there is no such file"),
        ((str(DATA / "loops.py"), "--from", "smach", "--arguments", "x.json"), 2, "--arguments are for --execute"),
        ((str(DATA / "states_lib.py"), "--from", "smach"), 1, "no SMACH machine was found"),
        ((str(DATA.parent / "broken"), "--from", "smach"), 1, "there is no such file"),
    ],
)
def test_wrong_use_is_explained(grip, arguments, status, words):
    done = grip("import", *arguments)
    assert (done.returncode, words in done.stderr) == (status, True), done.stderr


def test_what_is_no_python_of_any_age_is_named_with_its_line(grip, tmp_path):
    file = tmp_path / "broken.py"
    file.write_text("import smach\nprint 'a'\nwith sm\n")
    done = grip("import", file, "--from", "smach")
    assert done.returncode == 1
    assert f"{file}:2: is neither Python 3 nor Python 2" in done.stderr
