"""`grip apply` edits a task file by the commands that Python and the page use."""

import json

import pytest

from grip_bt.cli.__main__ import main

TASK = """\
grip: 1
name: two
root:
  kind: sequence  # in order
  children:
    first: {node: flow/succeed}
    second: {node: flow/log, with: {message: here}}  # the second
"""


@pytest.fixture
def task(tmp_path):
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    file = tmp_path / "tasks" / "two.yaml"
    file.parent.mkdir()
    file.write_text(TASK)
    return file


def test_commands_change_their_own_lines(task, capsys):
    commands = [
        {"do": "rename", "path": "first", "name": "begin"},
        {"do": "move", "path": "second", "parent": "/", "index": 0},
    ]
    assert main(["apply", str(task), json.dumps(commands)]) == 0
    assert "2 commands applied" in capsys.readouterr().out
    text = task.read_text()
    assert text.index("second") < text.index("begin: {node: flow/succeed}")
    assert "# in order" in text
    assert "# the second" in text


def test_a_part_becomes_a_file(task, tmp_path):
    assert main(["apply", str(task), '{"do": "extract", "path": "second", "file": "tasks/part.yaml"}']) == 0
    assert "kind: subtask" in task.read_text()
    assert main(["check", str(task), str(tmp_path / "tasks" / "part.yaml")]) == 0


def test_a_dry_run_prints_the_text_and_changes_nothing(task, capsys):
    assert main(["apply", str(task), '{"do": "remove", "path": "first"}', "--dry-run"]) == 0
    assert "flow/succeed" not in capsys.readouterr().out
    assert task.read_text() == TASK


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("{", "no JSON"),
        ('{"do": "burn"}', "not a command"),
        ('{"do": "rename", "path": "nobody", "name": "x"}', "nobody"),
        ('[{"do": "remove", "path": "first"}, {"do": "remove", "path": "first"}]', "first"),
    ],
)
def test_what_cannot_be_done_changes_nothing_and_says_why(task, capsys, words, says):
    assert main(["apply", str(task), words]) == 1
    assert says in capsys.readouterr().err
    assert task.read_text() == TASK


def test_a_file_that_is_there_is_not_written_over(task, tmp_path, capsys):
    (tmp_path / "tasks" / "part.yaml").write_text("mine")
    assert main(["apply", str(task), '{"do": "extract", "path": "second", "file": "tasks/part.yaml"}']) == 1
    assert "part.yaml" in capsys.readouterr().err
    assert (tmp_path / "tasks" / "part.yaml").read_text() == "mine"
    assert task.read_text() == TASK


def test_a_comment_is_written(task):
    command = {"do": "comment", "path": "first", "text": "at once\nand only once"}
    assert main(["apply", str(task), json.dumps(command)]) == 0
    assert task.read_text() == TASK.replace("    first:", "    # at once\n    # and only once\n    first:")
