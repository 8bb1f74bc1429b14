"""A history leads back and forth, on every branch, to the very bytes that were there."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from random_commands import commands
from random_tasks import tasks
from random_texts import with_comments

from grip_bt.base.errors import EditError
from grip_bt.task import dumps, read_text
from grip_bt.task.edit import Group, History, Remove, Rename, Set

unhurried = settings(
    deadline=None, max_examples=40, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
TEXT = "grip: 1\nname: a\nroot:\n  kind: sequence\n  children:\n    # one\n    a: {node: b/c}\n    d: {node: e/f}\n"


@unhurried
@given(st.data(), tasks, st.randoms(use_true_random=False))
def test_undone_and_redone_n_times_the_text_has_the_same_bytes(data, task, random):
    history = History(read_text(with_comments(dumps(task), random)[0]))
    texts = [history.document.text]
    for _ in range(data.draw(st.integers(1, 6))):
        try:
            history.do(data.draw(commands(history.document.task)))
        except EditError:
            continue
        texts.append(history.document.text)
    for text in reversed(texts[:-1]):
        history.undo()
        assert history.document.text == text
    assert not history.can_undo
    for text in texts[1:]:
        history.redo()
        assert history.document.text == text
    assert not history.can_redo


@unhurried
@given(st.data(), tasks)
def test_every_moment_of_every_branch_can_be_reached_from_every_other(data, task):
    history = History(read_text(dumps(task)))
    texts = {0: history.document.text}
    for _ in range(data.draw(st.integers(1, 8))):
        if history.can_undo and data.draw(st.booleans()):
            history.undo()
        try:
            history.do(data.draw(commands(history.document.task)))
        except EditError:
            continue
        texts[history.at.number] = history.document.text
    assert [m.number for m in history.moments] == sorted(texts)
    for _ in range(3):
        number = data.draw(st.sampled_from(sorted(texts)))
        history.go(number)
        assert history.at.number == number
        assert history.document.text == texts[number]


def test_a_command_after_an_undo_begins_a_branch_and_the_old_one_stays():
    history = History(read_text(TEXT))
    history.do(Remove(path="a"))
    history.undo()
    history.do(Rename(path="d", name="g"))
    assert [(m.number, m.parent, m.title) for m in history.moments] == [
        (0, None, "opened"),
        (1, 0, "remove a"),
        (2, 0, "rename d to g"),
    ]
    history.go(1)
    assert "# one" not in history.document.text
    assert "d: {node: e/f}" in history.document.text
    history.undo()
    assert history.document.text == TEXT
    history.redo()
    assert history.at.number == 1, "redo takes the branch that was left last"


def test_a_group_is_one_moment():
    history = History(read_text(TEXT))
    history.do(Group(title="tidy", commands=(Remove(path="a"), Rename(path="d", name="a"))))
    assert history.at.title == "tidy"
    history.undo()
    assert history.document.text == TEXT


def test_nothing_to_undo_or_redo_and_refused_commands_leave_the_history_alone():
    history = History(read_text(TEXT))
    with pytest.raises(EditError, match="nothing to undo"):
        history.undo()
    with pytest.raises(EditError, match="nothing to redo"):
        history.redo()
    with pytest.raises(EditError, match="no revision 7"):
        history.go(7)
    with pytest.raises(EditError, match="did you mean 'doc'"):
        history.do(Set(path="a", key=("docs",), value="x"))
    assert history.at.number == 0
    assert history.document.text == TEXT
