"""Where two forms of a task differ, as two runs that the page shows like those of the journal."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from grip_bt.base.values import Failure
from grip_bt.compilers.restructure import Difference, Restructured, moved, play
from grip_bt.compilers.restructure.equivalence import End
from grip_bt.runtime.recorder import preview
from grip_bt.task import Task
from grip_bt.task.catalog import Catalog
from grip_bt.task.model import Leaf
from grip_bt.task.walking import outcomes_of
from grip_gui.documents import finder
from grip_gui.edit_messages import PlayView
from grip_gui.projection import project_task
from grip_gui.run_messages import RunEvent


def plays(task: Task, result: Restructured, difference: Difference, catalog: Catalog, file: str) -> list[PlayView]:
    """Return what the form as it is does with a script, and what the other form does.

    Args:
        task: the task as it is.
        result: its other form.
        difference: the script with which they differ.
        catalog: the nodes that exist.
        file: the task's file, relative to the project.
    """
    other = moved(difference.script, result.paths)
    return [_play(task, difference.script, catalog, file), _play(result.task, other, catalog, file)]


def _play(task: Task, script: tuple[End, ...], catalog: Catalog, file: str) -> PlayView:
    events = _Events()
    end = play(task, catalog, script, events.by)
    outcome = end[0] if end and end[0] != "error" else None
    status = (
        "stopped" if not end else end[0] if outcome is None else task.outcomes.get(outcome, _meaning(task, outcome))
    )
    events.add("/", "run_ended", outcome, None, {"status": status})
    return PlayView(task=project_task(task, file, finder(catalog)), status=status, outcome=outcome, events=events.all)


def _meaning(task: Task, outcome: str) -> str:
    root = task.root
    known = root.meaning if isinstance(root, Leaf) else outcomes_of(root)
    return known.get(outcome, "failure")


class _Events:
    """The observer that notes what happens as the journal would."""

    def __init__(self) -> None:
        self.all: list[RunEvent] = []
        self._now: Callable[[], float] = lambda: 0.0

    def by(self, now: Callable[[], float]) -> _Events:
        """Take the run's clock [s]; return the observer."""
        self._now = now
        return self

    def add(self, path: str, event: str, outcome: str | None, code: str | None, data: dict[str, Any]) -> None:
        """Note one event."""
        seq = len(self.all)
        self.all.append(RunEvent(seq=seq, t=self._now(), path=path, event=event, outcome=outcome, code=code, data=data))

    def entered(self, path: str) -> None:
        """An activation begins."""
        self.add(path, "enter", None, None, {})

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        """An activation ended."""
        data = {"message": failure.message} if failure and failure.message else {}
        self.add(path, "exit", outcome, failure.code if failure else None, data)

    def interrupted(self, path: str) -> None:
        """An activation was halted."""
        self.add(path, "interrupted", None, None, {})

    def message(self, path: str, text: str) -> None:
        """A node says how it goes."""
        self.add(path, "message", None, None, {"text": text})

    def wrote(self, path: str, variable: str, type_name: str, value: Any) -> None:
        """A variable was written."""
        data = {"variable": variable, "type": type_name, "preview": preview(value)}
        self.add(path, "write", None, None, data)
