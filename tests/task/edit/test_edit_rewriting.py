"""A text that a person has typed, as a command of the history."""

import pytest
from hypothesis import given, settings
from random_tasks import tasks

from grip_bt.base.errors import DocumentError
from grip_bt.task import dumps, read_text
from grip_bt.task.edit import History, apply_to_document, rewrite

BEFORE = """\
grip: 1
name: demo
root:
  kind: sequence
  children:
    # the camera first
    look: {node: sensor/overhead}
    home: {node: arm/move_to, with: {state: home}}
"""


@given(tasks, tasks)
@settings(max_examples=60, deadline=None)
def test_any_task_is_rewritten_to_any_other_and_back_to_the_bytes(one, other):
    document, text = read_text(dumps(one)), dumps(other)
    edited = apply_to_document(document, rewrite(document, text))
    assert edited.document.text == text


def test_comments_and_spelling_are_those_that_were_typed():
    text = BEFORE.replace("# the camera first", "# first of all").replace(
        "{node: sensor/overhead}", '{"node": sensor/overhead}'
    )
    history = History(read_text(BEFORE))
    history.do(rewrite(history.document, text))
    assert history.document.text == text
    assert history.at.title == "edit the text"
    history.undo()
    assert history.document.text == BEFORE
    history.redo()
    assert history.document.text == text


def test_a_node_with_another_name_or_place_is_followed():
    document = read_text(BEFORE)
    edited = apply_to_document(document, rewrite(document, BEFORE.replace("home:", "rest:")))
    assert edited.path("home") == "rest"
    lines = BEFORE.splitlines(keepends=True)
    swapped = "".join([*lines[:5], lines[7], lines[5], lines[6]])
    moved = apply_to_document(document, rewrite(document, swapped))
    assert list(moved.document.task.root.children) == ["home", "look"]
    assert moved.path("home") == "home"


def test_what_is_no_task_is_refused_with_its_place():
    with pytest.raises(DocumentError) as error:
        rewrite(read_text(BEFORE), BEFORE.replace("kind: sequence", "kind: sequins"))
    assert error.value.line == 4
