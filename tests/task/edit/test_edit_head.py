"""The comment of a task, at the top of its file: found, written and taken back; nothing but its own lines changes."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from random_tasks import tasks
from random_texts import with_comments

from grip_bt.base.errors import EditError
from grip_bt.task import dumps, fmt, read_text, walk
from grip_bt.task.edit import Comment, Group, History, Rename, Set, apply, apply_to_document, command_of, comment_of

unhurried = settings(
    deadline=None, max_examples=60, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
BODY = "grip: 1\nname: demo\n# all that happens\nroot: {node: flow/wait}\n"
TEXT = "# Clears a table.\n#   It needs a hand.\n\n#by the people of the lab\n\n" + BODY


def said(text):
    return comment_of(read_text(text), "")


def put(text, comment):
    """Return a text with another comment."""
    after = apply_to_document(read_text(text), Comment(path="", text=comment))
    assert comment_of(after.document, "") == comment
    return after.document.text


def test_the_comment_of_a_task_is_what_stands_at_the_top_of_its_file():
    assert said(TEXT) == "Clears a table.\n  It needs a hand.\n\nby the people of the lab"
    assert said(BODY) == ""
    assert said("\n\n" + TEXT) == said(TEXT)
    assert said("\ufeff" + TEXT) == said(TEXT)
    assert said("{grip: 1, name: demo, root: {node: flow/wait}}\n") == ""
    assert said("# in braces\n{grip: 1, name: demo, root: {node: flow/wait}}\n") == "in braces"


def test_before_or_after_the_mark_of_a_document():
    assert said("---\n" + TEXT) == said(TEXT)
    assert said("# before\n---\n" + BODY) == "before"
    assert put("# before\n---\n# after\n" + BODY, "new") == "# new\n---\n# after\n" + BODY


def test_a_new_one_goes_above_the_first_key_and_leaves_with_its_blank_lines():
    assert put(BODY, "one\ntwo") == "# one\n# two\n" + BODY
    assert put("\ufeff" + BODY, "one") == "\ufeff# one\n" + BODY
    assert put("---\n" + BODY, "one") == "---\n# one\n" + BODY
    assert put(TEXT, "") == BODY
    assert put(BODY, "") == BODY


def test_the_comment_of_a_root_that_is_the_first_key_is_not_that_of_the_task():
    text = "# the task\n\n# the root\nroot: {node: flow/wait}\ngrip: 1\nname: demo\n"
    assert said(text) == "the task"
    assert put(text, "") == text.removeprefix("# the task\n\n")
    assert put(text, "else") == text.replace("the task", "else")
    assert comment_of(read_text(put(text, "else")), "/") == "the root"


def test_ends_of_lines_stay():
    text = TEXT.replace("\n", "\r\n")
    assert put(text, "one\ntwo") == "# one\r\n# two\r\n\r\n" + BODY.replace("\n", "\r\n")


def test_undo_and_redo_lead_to_the_very_bytes():
    history = History(read_text(TEXT))
    history.do(Comment(path="", text="else"))
    history.do(Set(path="", key=("doc",), value="Clear the table."))
    history.do(command_of({"do": "comment", "path": "", "text": ""}))
    last = history.document.text
    assert [moment.title for moment in history.moments][-1] == "no comment on the task"
    for _ in range(3):
        history.undo()
    assert history.document.text == TEXT
    for _ in range(3):
        history.redo()
    assert history.document.text == last


def test_it_is_one_gesture_with_others_and_no_node_goes_elsewhere_by_it():
    text = TEXT.replace("root: {node: flow/wait}", "root: {kind: sequence, children: {a: {node: flow/wait}}}")
    command = Group(commands=(Comment(path="", text="new"), Rename(path="a", name="b")))
    after = apply_to_document(read_text(text), command)
    assert after.document.text.startswith("# new\n\ngrip: 1\n")
    assert (after.path("a"), after.path("/")) == ("b", "/")


def test_a_task_without_its_text_stays_as_it_is():
    task = read_text(TEXT).task
    assert apply(task, Comment(path="", text="why")).task == task


@pytest.mark.parametrize(
    ("text", "words"),
    [("a\0b", "can't have the character '\\x00'"), ("x" * 10_001, "10000 characters, not 10001; shorten it")],
)
def test_what_can_not_be_a_comment_is_refused(text, words):
    with pytest.raises(EditError) as refused:
        apply_to_document(read_text(TEXT), Comment(path="", text=text))
    assert words in str(refused.value)


@unhurried
@given(
    tasks,
    st.randoms(use_true_random=False),
    st.from_regex(r"\A(#?[a-z ]{0,8}\n){0,4}\Z"),
    st.from_regex(r"\A([a-z#:{' -]{0,12}[a-z]\n{0,2}){0,3}\Z"),
)
def test_only_lines_at_the_top_change(task, random, top, text):
    lines = "".join(f"{line}\n" if line.startswith("#") else "\n" for line in top.split("\n")[:-1])
    before = read_text(lines + with_comments(dumps(task), random)[0])
    after = apply_to_document(before, Comment(path="", text=text))
    assert comment_of(after.document, "") == text.strip("\n")
    assert after.document.task == before.task
    first = next(iter(before.tree.entries.values())).start
    assert after.document.text.endswith(before.text[first:])
    for path, _ in walk(before.task.root):
        assert comment_of(after.document, path) == comment_of(before, path)
    for line in text.split("\n"):
        assert line in fmt(after.document.text)
