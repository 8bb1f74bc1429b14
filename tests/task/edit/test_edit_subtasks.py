"""Edit commands on subtasks and on the ports of a task."""

from __future__ import annotations

from typing import Any

import pytest

from grip_bt.base.errors import EditError
from grip_bt.task import read_text
from grip_bt.task.edit import apply_to_document, command_of

TEXT = """\
# counts
grip: 1
name: count
inputs: {limit: int}  # given from outside
outputs: {reached: int}
root:
  kind: sequence
  children:
    first: {kind: subtask, task: tasks/count.yaml, in: {start: limit}, out: {reached: reached}}
    again:
      kind: loop
      while: reached < limit
      child:
        add: {node: flow/compute, with: {expression: a}, in: {a: reached}, out: {value: reached}}
"""


@pytest.mark.parametrize(
    ("command", "wanted"),
    [
        (
            {"do": "rename_variable", "path": "", "name": "limit", "to": "up_to"},
            ["inputs: {up_to: int}  # given from outside", "in: {start: up_to}", "while: reached < up_to"],
        ),
        (
            {"do": "rename_variable", "path": "", "name": "reached", "to": "got"},
            ["outputs: {got: int}", "out: {reached: got}", "while: got < limit", "in: {a: got}, out: {value: got}"],
        ),
        (
            {"do": "set", "path": "first", "key": ["in", "by"], "value": "limit"},
            ["        start: limit\n        by: limit\n"],
        ),
        ({"do": "unset", "path": "first", "key": ["out", "reached"]}, ["in: {start: limit}}"]),
        ({"do": "set", "path": "first", "key": ["with", "by"], "value": 2}, ["with: {by: 2}"]),
        ({"do": "set", "path": "first", "key": ["task"], "value": "tasks/other.yaml"}, ["task: tasks/other.yaml"]),
        ({"do": "set", "path": "", "key": ["inputs", "by"], "value": "int"}, ["inputs: {limit: int, by: int}"]),
        ({"do": "set_meaning", "path": "first", "outcome": "bad", "meaning": "success"}, ["meaning: {bad: success}"]),
        ({"do": "remove", "path": "first"}, ["  children:\n    again:"]),
    ],
)
def test_a_command_changes_what_it_should(command: dict[str, Any], wanted: list[str]) -> None:
    document = read_text(TEXT)
    done = apply_to_document(document, command_of(command))
    for line in wanted:
        assert line in done.document.text


def test_a_port_that_is_used_is_not_undeclared() -> None:
    with pytest.raises(EditError, match="'limit' is used by again, first; unbind it there first"):
        apply_to_document(read_text(TEXT), command_of({"do": "undeclare", "path": "", "name": "limit"}))


def test_a_port_that_nobody_uses_is_undeclared() -> None:
    text = TEXT.replace("inputs: {limit: int}", "inputs: {limit: int, spare: int}")
    done = apply_to_document(read_text(text), command_of({"do": "undeclare", "path": "", "name": "spare"}))
    assert done.document.text == TEXT
