"""A command changes nothing but what it gives; what follows its nodes is led there and back."""

from copy import deepcopy

from hypothesis import HealthCheck, event, given, settings
from hypothesis import strategies as st
from random_commands import commands
from random_tasks import tasks

from grip_bt.base.errors import EditError
from grip_bt.task import Task, dumps, loads, read_text
from grip_bt.task.edit import Group, Patch, apply, apply_to_document, command_of, path_after
from grip_bt.task.edit.steps import backwards
from grip_bt.task.model import walk

unhurried = settings(
    deadline=None, max_examples=70, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)


@unhurried
@given(st.data(), tasks)
def test_a_command_leaves_its_task_as_it_was_and_leads_nodes_there_and_back(data, task):
    command = data.draw(commands(task))
    before = dumps(task)
    try:
        done = apply(task, command)
    except EditError:
        event(f"{command.do} refused")
        assert dumps(task) == before
        return
    event(f"{command.do} done")
    assert dumps(task) == before
    assert loads(dumps(done.task)) == done.task
    for path, _ in walk(task.root):
        now = path_after(path, done.steps)
        assert now is None or path_after(now, backwards(done.steps)) == path


@unhurried
@given(st.data(), tasks)
def test_an_edit_of_a_document_leaves_it_as_it_was(data, task):
    document = read_text(dumps(task))
    command = data.draw(commands(task))
    syntax = deepcopy(document.tree)
    try:
        done = apply_to_document(document, command)
    except EditError:
        assert document.tree == syntax
        return
    assert document.tree == syntax
    again = apply_to_document(document, command)
    assert again.document.text == done.document.text


@unhurried
@given(st.data(), tasks)
def test_groups_of_commands_are_all_of_them_and_survive_the_wire(data, task):
    current, parts = task, []
    for _ in range(data.draw(st.integers(1, 5))):
        command = data.draw(commands(current))
        try:
            current = apply(current, command).task
            parts.append(command)
        except EditError:
            continue
    group = Group(commands=tuple(parts))
    done = apply(task, group)
    assert dumps(done.task) == dumps(current)
    assert command_of(group.model_dump()) == group
    assert apply(task, command_of(Patch(steps=done.steps).model_dump())).task == done.task


@unhurried
@given(st.data(), tasks)
def test_what_an_edit_gives_is_what_a_full_check_of_its_data_gives(data, task):
    try:
        done = apply(task, data.draw(commands(task)))
    except EditError:
        return
    assert Task.model_validate(done.task.model_dump()) == done.task
