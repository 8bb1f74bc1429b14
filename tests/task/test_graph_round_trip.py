from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from random_tasks import tasks
from random_texts import with_comments

from grip_bt.task import dumps, fmt, loads

unhurried = settings(deadline=None, max_examples=100, suppress_health_check=[HealthCheck.too_slow])


@unhurried
@given(tasks)
def test_a_written_task_is_read_back_equal(task):
    assert loads(dumps(task)) == task


@unhurried
@given(tasks)
def test_what_dumps_writes_is_canonical(task):
    text = dumps(task)
    assert fmt(text) == text
    assert dumps(loads(text)) == text


@unhurried
@given(tasks, st.randoms(use_true_random=False))
def test_formatting_twice_changes_nothing_and_keeps_the_task_and_every_comment(task, random):
    text, comments = with_comments(dumps(task), random)
    once = fmt(text)
    assert fmt(once) == once
    assert loads(once) == task
    for comment in comments:
        assert comment in once
