"""What is known of the files that a task runs as subtasks: each is checked once, and seen as one node with ports."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from grip_bt.base.errors import SubtaskError
from grip_bt.base.issue import Issue
from grip_bt.task import Task
from grip_bt.task.catalog import Catalog, Manifest, manifest_of_task
from grip_bt.task.catalog.project_parts import Problem

Checked = tuple[list[Issue], Mapping[str, Iterable[str]]]
"""The issues of a task, and each of its outputs -> the outcomes with which it has been written."""


Look = tuple[Manifest | None, Problem | None]
"""Ports and outcomes of a file, where it can be read, and the issue that every subtask which runs it has."""


class Subtasks:
    """The files of one task, of those that they run, and so on.

    Args:
        check: checks one task; it may ask for further files while it does.
    """

    def __init__(self, catalog: Catalog, check: Callable[[Task], Checked]):
        self._catalog, self._check = catalog, check
        self._found: dict[str, Look] = {}
        self._chain: list[str] = []

    def look(self, file: str) -> Look:
        """Return what is known of a file."""
        if file in self._chain:
            chain = " -> ".join((*self._chain[self._chain.index(file) :], file))
            said = f"a task can't run itself: {chain}"
            return None, Problem("recursive-subtask", said, "take one of these steps out")
        if file not in self._found:
            self._chain.append(file)
            try:
                self._found[file] = self._look(file)
            finally:
                self._chain.pop()
        return self._found[file]

    def _look(self, file: str) -> Look:
        try:
            task = self._catalog.tasks.read(file)
        except SubtaskError as error:
            return None, Problem(
                "unknown-subtask", f"{file!r} can't be run: {error.reason}", "name a task file of the project"
            )
        issues, written = self._check(task)
        face, errors = manifest_of_task(file, task, written), [issue for issue in issues if issue.severity == "error"]
        if not errors:
            return face, None
        first = next((issue for issue in errors if issue.code == "recursive-subtask"), None)
        if first is not None:
            return face, Problem(first.code, first.message, first.fix)
        number = "an error" if len(errors) == 1 else f"{len(errors)} errors"
        at = errors[0].path or "the task"
        message = f"{file} has {number}; {at}: {errors[0].message} [{errors[0].code}]"
        return face, Problem("invalid-subtask", message, f"run `grip check {file}`, and fix it there")
