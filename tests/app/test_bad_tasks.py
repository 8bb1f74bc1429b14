"""Bad task files through the command: all issues with their places, exit status 1, and the file untouched."""

import pytest
from trial_project import grip

from grip_bt.cli.__main__ import main

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
def test_a_broken_task_is_refused_with_its_place(tmp_path, capsys, kind, verb):
    text, message = BROKEN[kind]
    task = tmp_path / "task.yaml"
    task.write_text(text)
    if kind == "an unknown key":  # one of each as users do, in processes of their own
        done = grip(verb, str(task))
        status, said = done.returncode, done.stdout + done.stderr
    else:
        status = main([verb, str(task), *(["--in-process"] if verb == "run" else [])])
        said = "".join(capsys.readouterr())
    assert status == 1
    assert "task.yaml:" in said
    assert message in said
    assert "Traceback" not in said
    assert task.read_text() == text


def test_a_missing_file_is_named(tmp_path, capsys):
    assert main(["run", str(tmp_path / "nothing.yaml"), "--in-process"]) == 1
    assert "nothing.yaml" in capsys.readouterr().err


def test_a_task_of_builtin_nodes_runs_anywhere(tmp_path):
    task = tmp_path / "task.yaml"
    task.write_text("grip: 1\nname: a\nroot: {node: flow/fail, with: {code: tired, message: enough}}\n")
    done = grip("run", str(task))
    assert done.returncode == 3
    assert "tired: enough" in done.stdout


def test_a_variable_can_be_set_and_a_wrong_one_is_refused(tmp_path, capsys):
    task = tmp_path / "task.yaml"
    task.write_text("grip: 1\nname: a\ndata: {n: int}\nroot: {node: flow/succeed}\n")
    run = ["run", str(task), "--in-process", "--set"]
    assert main([*run, "n=3"]) == 0
    assert main([*run, "m=3"]) == 1
    assert "'m'" in capsys.readouterr().err
    assert main([*run, "n=three"]) == 1
    assert "int" in capsys.readouterr().err


def test_an_unknown_demonstration_lists_those_that_exist(capsys):
    with pytest.raises(SystemExit) as end:
        main(["demo", "reactve"])
    assert end.value.code == 2
    said = capsys.readouterr().err
    assert "choose from" in said
    assert "reactive" in said
