"""The project folder: which task files it has, and the guard that no request reaches a file outside it."""

from __future__ import annotations

from pathlib import Path, PurePosixPath

from grip_bt.base.errors import DocumentError, GripError
from grip_gui.wire.task import TaskEntry


class OutsideProjectError(GripError):
    """A path leads out of the project folder, or isn't the path of a task file."""

    def __init__(self, path: str, why: str):
        self.path = path
        super().__init__(f"{path!r} {why}; name a task file below the project folder, such as 'tasks/pick.yaml'")


class ProjectFolder:
    """A folder with a grip.yaml (or just task files)."""

    def __init__(self, folder: Path | str):
        self.folder = Path(folder).resolve()
        if not self.folder.is_dir():
            raise DocumentError("this folder doesn't exist; make one with `grip new`", str(folder))

    @property
    def journal(self) -> Path:
        """The journal of the project's runs."""
        return self.folder / ".grip" / "runs.sqlite"

    def tasks(self) -> list[TaskEntry]:
        """Return the task files below `tasks/`, sorted by path; layout files aren't tasks."""
        files = sorted((self.folder / "tasks").rglob("*.yaml"))
        return [
            TaskEntry(path=file.relative_to(self.folder).as_posix(), name=file.stem)
            for file in files
            if not file.name.endswith(".layout.yaml") and self._inside(file)
        ]

    def task_file(self, path: str) -> Path:
        """Return the file at a path that came from outside, relative to the project folder.

        Raises:
            OutsideProjectError: the path is absolute, climbs, follows a link outwards, or isn't a YAML file.
            DocumentError: there is no such file.
        """
        file = self.settings_file(path)
        if not file.is_file():
            raise DocumentError("there is no such task file in the project", path)
        return file

    def new_task_file(self, path: str) -> Path:
        """Return where a new task file goes, at a path below `tasks/` that came from outside; nothing is there yet."""
        file = self.settings_file(path)
        if PurePosixPath(path).parts[0] != "tasks" or file.name.endswith(".layout.yaml"):
            raise OutsideProjectError(path, "isn't a place for a task")
        if file.exists():
            raise DocumentError("a file of this name already exists; choose another name", path)
        return file

    def settings_file(self, path: str) -> Path:
        """Return where a YAML file is or goes, at a path that came from outside, relative to the project folder.

        Raises:
            OutsideProjectError: the path leads elsewhere, or isn't one of a YAML file.
        """
        pure = PurePosixPath(path)
        if "\0" in path or "\\" in path or pure.is_absolute() or ".." in pure.parts:
            raise OutsideProjectError(path, "isn't a path inside the project")
        if pure.suffix not in {".yaml", ".yml"} or any(part.startswith(".") for part in pure.parts):
            raise OutsideProjectError(path, "isn't a task file")
        file = self.folder / pure
        if not self._inside(file):
            raise OutsideProjectError(path, "leads out of the project folder")
        return file

    def relative(self, file: Path) -> str:
        """Return a file's path relative to the project folder; outside of it there is none."""
        resolved = file.resolve()
        if not resolved.is_relative_to(self.folder):
            raise OutsideProjectError(str(file), "lies outside the project folder")
        return resolved.relative_to(self.folder).as_posix()

    def _inside(self, file: Path) -> bool:
        return file.resolve().is_relative_to(self.folder)
