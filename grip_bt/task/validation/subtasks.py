"""What is known of the files that a task runs as subtasks: each is checked once, and seen as one node with ports."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from grip_bt.base.errors import SubtaskError
from grip_bt.base.issue import Issue
from grip_bt.task import Task
from grip_bt.task.catalog import Catalog, Manifest, manifest_of_task

Checked = tuple[list[Issue], Mapping[str, Iterable[str]]]
"""The issues of a task, and each of its outputs -> the outcomes with which it has been written."""


@dataclass(frozen=True)
class CheckedFile:
    """What is known of one file.

    Attributes:
        face: its ports and outcomes; None when it can't be read.
        code: of the issue that every subtask which runs it has; empty when there is none.
    """

    face: Manifest | None
    code: str = ""
    message: str = ""
    fix: str = ""


class Subtasks:
    """The files of one task, of those that they run, and so on.

    Args:
        check: checks one task; it may ask for further files while it does.
    """

    def __init__(self, catalog: Catalog, check: Callable[[Task], Checked]):
        self._catalog, self._check = catalog, check
        self._found: dict[str, CheckedFile] = {}
        self._chain: list[str] = []

    def look(self, file: str) -> CheckedFile:
        """Return what is known of a file."""
        if file in self._chain:
            chain = " -> ".join((*self._chain[self._chain.index(file) :], file))
            return CheckedFile(
                None, "recursive-subtask", f"a task can't run itself: {chain}", "take one of these steps out"
            )
        if file not in self._found:
            self._chain.append(file)
            try:
                self._found[file] = self._look(file)
            finally:
                self._chain.pop()
        return self._found[file]

    def _look(self, file: str) -> CheckedFile:
        try:
            task = self._catalog.tasks.read(file)
        except SubtaskError as error:
            return CheckedFile(
                None, "unknown-subtask", f"{file!r} can't be run: {error.reason}", "name a task file of the project"
            )
        issues, written = self._check(task)
        face, errors = manifest_of_task(file, task, written), [issue for issue in issues if issue.severity == "error"]
        if not errors:
            return CheckedFile(face)
        first = next((issue for issue in errors if issue.code == "recursive-subtask"), None)
        if first is not None:
            return CheckedFile(face, first.code, first.message, first.fix)
        number = "an error" if len(errors) == 1 else f"{len(errors)} errors"
        at = errors[0].path or "the task"
        message = f"{file} has {number}; {at}: {errors[0].message} [{errors[0].code}]"
        return CheckedFile(face, "invalid-subtask", message, f"run `grip check {file}`, and fix it there")
