"""Where the ends of a task's root lead."""

from __future__ import annotations

from grip_bt.task import Task


def default_outcome(task: Task, outcome: str, meaning: str) -> str | None:
    """Return the task's outcome for an end of the root that `on` doesn't map: the same word, or else its meaning."""
    return next((target for target in (outcome, meaning) if target in task.outcomes), None)
