"""Bad task files through the command: all issues with their places, exit status 1, and the file untouched."""

import pytest
from trial_project import grip

BROKEN = {
    "not yaml": ("grip: 1\nname: [\n", ":3:"),
    "a duplicate key": ("grip: 1\nname: a\nname: b\nroot: {node: flow/succeed}\n", ":3:1: "),
    "an unknown key": ("grip: 1\nname: a\nroot: {kind: sequnce, children: {}}\n", "did you mean 'sequence'?"),
    "an unknown node": ("grip: 1\nname: a\nroot: {node: flow/suceed}\n", "flow/succeed"),
    "an undeclared variable": (
        "grip: 1\nname: a\nroot: {node: grasp/remember, in: {grasp: g, tried: t}, out: {tried: t}}\n",
        "'g'",
    ),
}


@pytest.mark.parametrize("kind", BROKEN)
@pytest.mark.parametrize("verb", ["check", "run"])
def test_a_broken_task_is_refused_with_its_place(tmp_path, kind, verb):
    text, message = BROKEN[kind]
    task = tmp_path / "task.yaml"
    task.write_text(text)
    done = grip(verb, str(task))
    said = done.stdout + done.stderr
    assert done.returncode == 1
    assert "task.yaml:" in said
    assert message in said
    assert "Traceback" not in said
    assert task.read_text() == text


def test_a_missing_file_is_named(tmp_path):
    done = grip("run", str(tmp_path / "nothing.yaml"))
    assert done.returncode == 1
    assert "nothing.yaml" in done.stderr


def test_a_task_of_builtin_nodes_runs_anywhere(tmp_path):
    task = tmp_path / "task.yaml"
    task.write_text("grip: 1\nname: a\nroot: {node: flow/fail, with: {code: tired, message: enough}}\n")
    done = grip("run", str(task))
    assert done.returncode == 3
    assert "tired: enough" in done.stdout


def test_a_variable_can_be_set_and_a_wrong_one_is_refused(tmp_path):
    task = tmp_path / "task.yaml"
    task.write_text("grip: 1\nname: a\ndata: {n: int}\nroot: {node: flow/succeed}\n")
    assert grip("run", str(task), "--set", "n=3").returncode == 0
    done = grip("run", str(task), "--set", "m=3")
    assert done.returncode == 1
    assert "'m'" in done.stderr
    done = grip("run", str(task), "--set", "n=three")
    assert done.returncode == 1
    assert "int" in done.stderr


def test_an_unknown_demonstration_lists_those_that_exist():
    done = grip("demo", "reactve")
    assert done.returncode == 2
    assert "choose from" in done.stderr
    assert "reactive" in done.stderr
