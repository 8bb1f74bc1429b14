"""Comments of nodes: found, written and taken back; nothing but their own lines changes."""

import difflib

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from random_tasks import tasks
from random_texts import with_comments

from grip_bt.base.errors import EditError
from grip_bt.task import dumps, fmt, read_text, walk
from grip_bt.task.edit import Comment, Group, Rename, apply, apply_to_document, comment_of

unhurried = settings(
    deadline=None, max_examples=60, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
TEXT = """\
# A task.
grip: 1
name: demo

# what happens
root:   # in order
  kind: sequence
  children:
    # first of all

    # the camera,
    #   which is on the left
    look: {node: sensor/overhead}   # twice as slow
      # closes look
    think:
      node: flow/wait
    go: {node: flow/wait, with: {text: "# no comment"}}  # beside
    inner: {kind: sequence, children: {a: {node: flow/wait}}}
"""


def said(text, path):
    return comment_of(read_text(text), path)


def put(text, path, comment):
    """Return a text with another comment."""
    after = apply_to_document(read_text(text), Comment(path=path, text=comment))
    assert comment_of(after.document, path) == comment
    return after.document.text


def changes(before, after):
    return [line for line in difflib.ndiff(before.split("\n"), after.split("\n")) if line[:1] in "+-"]


def test_a_comment_is_what_stands_right_above_and_beside():
    assert said(TEXT, "/") == "what happens\nin order"
    assert said(TEXT, "look") == "the camera,\n  which is on the left\ntwice as slow"
    assert said(TEXT, "think") == ""
    assert said(TEXT, "go") == "beside"
    assert said(TEXT, "inner/a") == ""


def test_a_new_comment_goes_above_its_node():
    assert changes(TEXT, put(TEXT, "think", "for long\n\nor not")) == ["+     # for long", "+     #", "+     # or not"]


def test_one_line_beside_a_node_stays_beside_it_and_more_go_above():
    assert changes(TEXT, put(TEXT, "go", "away")) == [
        '-     go: {node: flow/wait, with: {text: "# no comment"}}  # beside',
        '+     go: {node: flow/wait, with: {text: "# no comment"}}  # away',
    ]
    assert changes(TEXT, put(TEXT, "go", "away\nand back")) == [
        "+     # away",
        "+     # and back",
        '-     go: {node: flow/wait, with: {text: "# no comment"}}  # beside',
        '+     go: {node: flow/wait, with: {text: "# no comment"}}',
    ]


def test_a_comment_goes_without_what_else_stands_around():
    after = put(TEXT, "look", "")
    assert "# first of all\n\n    look: {node: sensor/overhead}\n      # closes look\n" in after
    assert "camera" not in after


def test_the_root_and_a_node_in_braces_have_comments_too():
    assert "# all of it\nroot:\n" in put(TEXT, "/", "all of it")
    after = put(TEXT, "inner/a", "alone")
    assert "        # alone\n        a: {node: flow/wait}\n" in after
    assert put(TEXT, "inner/a", "") == TEXT


def test_ends_of_lines_and_a_missing_last_one_stay():
    text = TEXT.replace("\n", "\r\n").removesuffix("\r\n")
    after = put(text, "inner", "one\ntwo")
    assert after == text.replace("    inner:", "    # one\r\n    # two\r\n    inner:")
    assert put(text, "go", "away") == text.replace("# beside", "# away")


def test_a_comment_and_a_rename_are_one_gesture():
    command = Group(commands=(Comment(path="think", text="why"), Rename(path="think", name="wait")))
    after = apply_to_document(read_text(TEXT), command)
    assert "    # why\n    wait:\n" in after.document.text
    assert after.path("think") == "wait"


def test_a_task_without_its_text_stays_as_it_is():
    task = read_text(TEXT).task
    assert apply(task, Comment(path="look", text="why")).task == task


@pytest.mark.parametrize(
    ("path", "text", "words"),
    [
        ("lok", "x", "did you mean 'look'"),
        ("look", "a\0b", "can't have the character '\\x00'"),
        ("look", "x" * 10_001, "10000 characters, not 10001; shorten it"),
    ],
)
def test_what_can_not_be_a_comment_is_refused_and_changes_nothing(path, text, words):
    with pytest.raises(EditError) as refused:
        apply_to_document(read_text(TEXT), Comment(path=path, text=text))
    assert words in str(refused.value)


@unhurried
@given(st.data(), tasks, st.randoms(use_true_random=False), st.from_regex(r"\A([a-z#:{' -]{0,12}[a-z]\n?){0,3}\Z"))
def test_only_lines_of_comments_change(data, task, random, text):
    before = read_text(with_comments(dumps(task), random)[0])
    path = data.draw(st.sampled_from([path for path, _ in walk(before.task.root)]))
    try:
        after = apply_to_document(before, Comment(path=path, text=text))
    except EditError as error:
        if "fmt" not in str(error):
            raise
        return
    assert comment_of(after.document, path) == text.strip("\n")
    assert after.document.task == before.task
    plain = [[line.partition(" #")[0].rstrip() for line in t.text.split("\n")] for t in (before, after.document)]
    if "{" not in before.text and "'" not in before.text and '"' not in before.text:
        bare = [[line for line in lines if line.strip() and not line.strip().startswith("#")] for lines in plain]
        assert bare[0] == bare[1]
    others = [other for other, _ in walk(before.task.root) if other != path]
    for other in others:
        if comment_of(before, other):
            assert comment_of(after.document, other) == comment_of(before, other)


@unhurried
@given(tasks, st.randoms(use_true_random=False))
def test_the_formatter_keeps_the_comments_of_nodes(task, random):
    text = with_comments(dumps(task), random)[0]
    for path, _ in walk(read_text(text).task.root):
        for line in said(text, path).split("\n"):
            assert line in fmt(text)
