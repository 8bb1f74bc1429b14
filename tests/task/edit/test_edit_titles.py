"""What histories call edits: words for people, for every command there is."""

from typing import get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_commands import commands
from random_tasks import tasks

from grip_bt.task.edit import command_of, title_of
from grip_bt.task.edit.commands import LONGEST, AnyCommand

CLIP = {"name": "look", "node": {"node": "sensor/overhead"}}
TITLES = [
    ({"do": "add", "parent": "/", "name": "a", "node": {"node": "b/c"}}, "add a to the root"),
    ({"do": "paste", "parent": "pick", "clip": CLIP}, "paste look into pick"),
    ({"do": "remove", "path": "pick/a"}, "remove pick/a"),
    ({"do": "move", "path": "pick/a", "parent": "pick", "index": 0}, "reorder pick/a"),
    ({"do": "move", "path": "pick/a", "parent": "/"}, "move pick/a into the root"),
    ({"do": "rename", "path": "a", "name": "b"}, "rename a to b"),
    ({"do": "set", "path": "a", "key": ["with", "arm"], "value": "left"}, "set arm of a to left"),
    ({"do": "set", "path": "", "key": ["doc"], "value": "Long. " * 9}, "set documentation of the task"),
    ({"do": "set", "path": "/", "key": ["memory"], "value": False}, "set memory of the root to no"),
    ({"do": "unset", "path": "a", "key": ["times"]}, "unset times of a"),
    ({"do": "comment", "path": "a", "text": "why"}, "comment on a"),
    ({"do": "comment", "path": "a", "text": " "}, "no comment on a"),
    ({"do": "comment", "path": "", "text": "why"}, "comment on the task"),
    ({"do": "connect", "path": "a", "outcome": "success", "target": "b"}, "connect success of a to b"),
    ({"do": "disconnect", "path": "a", "outcome": "success"}, "disconnect success of a"),
    ({"do": "wrap", "paths": ["a", "b"], "kind": "invert", "name": "c"}, "wrap a, b in an invert"),
    ({"do": "wrap", "paths": list("abcde"), "kind": "for_each", "name": "c"}, "wrap a, b, c and 2 more in a for each"),
    ({"do": "unwrap", "path": "a"}, "unwrap a"),
    ({"do": "change_kind", "path": "/", "kind": "state_machine"}, "change the root to a state machine"),
    ({"do": "convert", "path": "a", "to": "bt"}, "convert a to composites"),
    ({"do": "convert", "path": "/", "to": "sm"}, "convert the root to state machines"),
    ({"do": "extract", "path": "a", "file": "tasks/a.yaml"}, "extract a to tasks/a.yaml"),
    ({"do": "set", "path": "a", "key": ["in", "cloud"], "value": "c"}, "cloud of a reads c"),
    ({"do": "unset", "path": "a", "key": ["out", "cloud"]}, "cloud of a writes no variable"),
    ({"do": "set_meaning", "path": "a", "outcome": "none", "meaning": "failure"}, "none of a means failure"),
    ({"do": "set_meaning", "path": "a", "outcome": "none", "meaning": None}, "none of a means what its manifest says"),
    ({"do": "declare", "path": "", "name": "cloud", "variable": "PointCloud"}, "declare cloud in the task"),
    ({"do": "undeclare", "path": "a", "name": "cloud"}, "remove the variable cloud of a"),
    ({"do": "rename_variable", "path": "", "name": "a", "to": "b"}, "rename the variable a to b"),
    ({"do": "rename_outcome", "path": "", "outcome": "a", "to": "b"}, "rename the outcome a of the task to b"),
    ({"do": "group", "title": "tidy", "commands": []}, "tidy"),
    ({"do": "group", "commands": [{"do": "unwrap", "path": "a"}]}, "unwrap a"),
    (
        {"do": "group", "commands": [{"do": "unwrap", "path": "a"}, {"do": "remove", "path": "b"}]},
        "unwrap a and 1 more",
    ),
    ({"do": "patch", "title": "remove a", "steps": []}, "remove a"),
    ({"do": "patch", "steps": []}, "change several things"),
]


@pytest.mark.parametrize(("command", "title"), TITLES, ids=[title for _, title in TITLES])
def test_a_command_has_a_title_in_words(command, title):
    assert title_of(command_of(command)) == title


def test_no_command_is_without_a_title():
    assert {type(command_of(command)) for command, _ in TITLES} == set(get_args(AnyCommand))


@settings(deadline=None, max_examples=60)
@given(st.data(), tasks)
def test_titles_are_one_short_line(data, task):
    command = data.draw(commands(task))
    title = title_of(command)
    assert 0 < len(title) <= LONGEST
    assert title == " ".join(title.split())
    assert "_" not in command.do or title.split()[0] != command.do
