"""A history that was stored goes on as if nobody had left: the same moments, the same bytes, bounded."""

import json

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from random_commands import commands
from random_tasks import tasks
from random_texts import with_comments

from grip_bt.base.errors import DocumentError, EditError
from grip_bt.task import dumps, read_text
from grip_bt.task.edit import History, Remove, Rename, Set, history_path, load_history, save_history
from grip_bt.task.edit.history import restored, stored

unhurried = settings(
    deadline=None, max_examples=40, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)
TEXT = "grip: 1\nname: a\nroot:\n  kind: sequence\n  children:\n    # one\n    a: {node: b/c}\n    d: {node: e/f}\n"


@unhurried
@given(st.data(), tasks, st.randoms(use_true_random=False))
def test_undo_and_redo_of_a_stored_history_are_the_identity_on_bytes(data, task, random):
    history = History(read_text(with_comments(dumps(task), random)[0]))
    texts = {0: history.document.text}
    for _ in range(data.draw(st.integers(1, 6))):
        if history.can_undo and data.draw(st.booleans()):
            history.undo()
        try:
            history.do(data.draw(commands(history.document.task)))
        except EditError:
            continue
        texts[history.at.number] = history.document.text
        if data.draw(st.booleans()):
            history = restored(stored(history), history.document)
    again = restored(stored(history), history.document)
    assert (again.moments, again.at) == (history.moments, history.at)
    assert again.document.text == history.document.text
    number = again.at.number
    steps = 0
    while again.can_undo:
        again.undo()
        steps += 1
        assert again.document.text == texts[again.at.number]
    for _ in range(steps):
        again.redo()
    assert (again.at.number, again.document.text) == (number, texts[number])
    for other in data.draw(st.permutations(sorted(texts))):
        again.go(other)
        assert again.document.text == texts[other]


@unhurried
@given(st.data(), tasks, st.integers(1, 5))
def test_a_history_holds_no_more_than_its_limit_and_its_texts_stay_reachable(data, task, limit):
    history = History(read_text(dumps(task)), limit)
    texts = {0: history.document.text}
    for _ in range(data.draw(st.integers(3, 10))):
        if history.can_undo and data.draw(st.booleans()):
            history.undo()
        try:
            history.do(data.draw(commands(history.document.task)))
        except EditError:
            continue
        texts[history.at.number] = history.document.text
        assert len(history.moments) <= limit
        assert history.at.number == max(texts)
    for moment in history.moments:
        history.go(moment.number)
        assert history.document.text == texts[moment.number]


def test_a_history_lies_beside_its_task_and_goes_on_in_another_process(tmp_path):
    task = tmp_path / "tasks" / "pick.yaml"
    task.parent.mkdir()
    task.write_text(TEXT)
    path = history_path(task)
    assert path == tmp_path / "tasks" / ".grip" / "history" / "pick.yaml.json"
    history = load_history(path, read_text(TEXT))
    history.do(Rename(path="a", name="x"))
    history.do(Set(path="x", key=("with", "speed"), value=float("inf")))
    history.undo()
    save_history(history, path)
    again = load_history(path, history.document)
    assert [m.title for m in again.moments] == ["opened", "rename a to x", "set speed of x to inf"]
    again.redo()
    assert again.document.task.root.children["x"].with_["speed"] == float("inf")
    again.go(0)
    assert again.document.text == TEXT
    assert [p.name for p in path.parent.iterdir()] == ["pick.yaml.json"]


def test_a_change_from_outside_is_one_more_moment(tmp_path):
    history = History(read_text(TEXT))
    history.do(Remove(path="a"))
    save_history(history, tmp_path / "h.json")
    text = history.document.text.replace("name: a", "name: other  # mine")
    again = load_history(tmp_path / "h.json", read_text(text))
    assert (again.at.title, again.document.text) == ("changed outside", text)
    again.undo()
    again.undo()
    assert again.document.text == TEXT


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda data: data.update(grip_history=4), "can't be read"),
        (lambda data: data["moments"][-1].update(text="grip: 1\n"), "can't be read .* is missing"),
        (lambda data: data.update(at=9), "can't be read"),
        (lambda data: data["moments"].pop(0), "can't be read"),
        (lambda data: data["moments"][2].update(parent=2), "can't be read"),
        (lambda data: data["moments"][2].update(number=1), "can't be read"),
        (lambda data: data["moments"][1].update(parent=None), "can't be read"),
        (lambda data: data["moments"][1].update(steps=[{"step": "burn"}]), "can't be read"),
        (lambda data: data.clear(), "can't be read"),
    ],
)
def test_a_damaged_history_is_refused_and_says_what_to_do(tmp_path, change, words):
    history = History(read_text(TEXT))
    history.do(Remove(path="a"))
    history.undo()
    history.do(Rename(path="d", name="g"))
    data = json.loads(stored(history))
    change(data)
    path = tmp_path / "h.json"
    path.write_text(json.dumps(data))
    with pytest.raises(DocumentError, match=words) as caught:
        load_history(path, read_text(TEXT))
    assert "delete the file to start a new one" in str(caught.value)


def test_a_history_that_cannot_be_written_is_a_typed_error(tmp_path):
    (tmp_path / ".grip").write_text("in the way")
    with pytest.raises(DocumentError, match="can't be written"):
        save_history(History(read_text(TEXT)), history_path(tmp_path / "t.yaml"))


def test_a_forgotten_moment_is_said_to_be_gone():
    history = History(read_text(TEXT), limit=2)
    for name in ("x", "y", "z"):
        history.do(Set(path="", key=("doc",), value=name))
    with pytest.raises(EditError, match="no revision 0 any more; the last is 3"):
        history.go(0)
