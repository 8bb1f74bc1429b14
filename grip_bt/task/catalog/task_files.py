"""Task files that other tasks run as subtasks: where they are looked for, and their manifest as nodes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Protocol

from grip_bt.base.errors import DocumentError, SubtaskError, nearest
from grip_bt.base.files import text_in
from grip_bt.base.frozen import FrozenDict
from grip_bt.task import Task, load
from grip_bt.task.parts import has_value, type_of

from .manifest import InputPort, Manifest, OutputPort


class TaskFiles(Protocol):
    """Where subtasks come from."""

    def read(self, file: str) -> Task:
        """Return the task in a file, named as in `task:` of a subtask.

        Raises:
            SubtaskError: there is no such file, it can't be used, or it isn't a task.
        """

    def mentioning(self, text: str) -> Sequence[str]:
        """Return the files that there are, as `read` names them; those that surely don't hold a text may be left out.

        Not each of them is a task.
        """


class TaskTexts:
    """Tasks that are at hand, by the name that `task:` calls them."""

    def __init__(self, tasks: Mapping[str, Task], missing: str = "there is no such file"):
        self._tasks, self._missing = dict(tasks), missing

    def read(self, file: str) -> Task:
        """Return a task."""
        if file not in self._tasks:
            raise SubtaskError(file, f"{self._missing}{nearest(file, self._tasks)}")
        return self._tasks[file]

    def mentioning(self, text: str) -> Sequence[str]:
        """Return all of them: what the texts were isn't known any more."""
        return tuple(self._tasks)


NO_TASK_FILES = TaskTexts({}, "no project is known in which it could be; load the task from its project's folder")


class TaskFolder:
    """The task files of one project; nothing outside its folder is read. A file is read again when it has changed."""

    def __init__(self, folder: Path):
        self._folder = folder.resolve()
        self._known: dict[str, tuple[tuple[int, int], Task]] = {}

    def read(self, file: str) -> Task:
        """Return the task in a file below the folder."""
        path = self._path(file)
        try:
            there = path.stat()
        except OSError:
            raise SubtaskError(
                file, f"there is no such file{nearest(file, self._files())} (below {self._folder})"
            ) from None
        stamp = (there.st_mtime_ns, there.st_size)
        if file not in self._known or self._known[file][0] != stamp:
            try:
                self._known[file] = stamp, load(path)
            except DocumentError as error:
                raise SubtaskError(file, f"it isn't a task: {error}") from error
        return self._known[file][1]

    def mentioning(self, text: str) -> Sequence[str]:
        """Return the YAML files in the folder, and below its `tasks`, that hold a text."""
        return [file for file in self._files() if text in (text_in(self._folder / file) or "")]

    def _path(self, file: str) -> Path:
        named = PurePosixPath(file)
        if named.is_absolute() or ".." in named.parts or "\\" in file or "\0" in file:
            raise SubtaskError(file, "name it from the project's folder on, such as `tasks/fetch.yaml`, without `..`")
        path = (self._folder / named).resolve()
        if not path.is_relative_to(self._folder):
            raise SubtaskError(file, "it lies outside of the project's folder; copy it into the project")
        return path

    def _files(self) -> list[str]:
        found = sorted(self._folder.glob("*.yaml")) + sorted((self._folder / "tasks").glob("**/*.yaml"))
        return [path.relative_to(self._folder).as_posix() for path in found]


def manifest_of_task(file: str, task: Task, surely_written: Mapping[str, Iterable[str]] | None = None) -> Manifest:
    """Return what a subtask looks like from outside: inputs, outputs and outcomes.

    Args:
        file: its file; messages call it so.
        surely_written: output -> the outcomes with which it has been written; by default, all of them.
    """
    written = surely_written or {}
    # not validated: the id is a file and no node of the catalogue, and a rule of the file tells of wrong types
    return Manifest.model_construct(
        id=file,
        doc=task.doc,
        implementation="",
        inputs=FrozenDict(
            {
                name: InputPort.model_construct(type=type_of(said), required=not has_value(said))
                for name, said in task.inputs.items()
            }
        ),
        outputs=FrozenDict(
            {
                name: OutputPort.model_construct(type=type_of(said), on=tuple(written.get(name, task.outcomes)))
                for name, said in task.outputs.items()
            }
        ),
        outcomes=task.outcomes,
    )
