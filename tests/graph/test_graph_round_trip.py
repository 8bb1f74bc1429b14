from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from random_tasks import tasks

from grip_bt.graph import dumps, fmt, loads, read_text

unhurried = settings(deadline=None, max_examples=200, suppress_health_check=[HealthCheck.too_slow])


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
    text, comments = _with_comments(dumps(task), random)
    once = fmt(text)
    assert fmt(once) == once
    assert loads(once) == task
    for comment in comments:
        assert comment in once


def _with_comments(text, random):
    """Put comments and blank lines between the entries of a canonical text."""
    tree = read_text(text).tree
    starts, stack = set(), list(tree.entries.values())
    while stack:
        entry = stack.pop()
        starts.add(entry.line)
        inner = getattr(entry.value, "entries", {})
        stack.extend(inner.values() if isinstance(inner, dict) else inner)
    lines, comments = [], []
    for number, line in enumerate(text.split("\n")[:-1], 1):
        if number in starts and random.random() < 0.3:
            comments.append(f"# above {number}.")
            indent = len(line) - len(line.lstrip())
            lines.extend([""] * random.randint(0, 2) + [" " * indent + comments[-1]])
        if number in starts and line.endswith((":", "}", "]")) and random.random() < 0.3:
            comments.append(f"# beside {number}.")
            line += "   " + comments[-1]
        lines.append(line)
    return "\n".join(lines) + "\n", comments
