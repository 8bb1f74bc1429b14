"""All open task files of a project: one lock, and one way in."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import RLock

from grip_bt.base.errors import DocumentError
from grip_bt.compilers.restructure import expanded, extracted
from grip_bt.task import Task, dumps, read_text
from grip_bt.task.document import Document
from grip_bt.task.edit import AnyCommand, Convert, Extract, Group, Inline
from grip_bt.task.edit.steps import Step
from grip_gui.editing.files import TextFile, layout_path, recovery_of
from grip_gui.editing.open_document import OpenDocument
from grip_gui.editing.views import catalog_of
from grip_gui.project import ProjectFolder


class DocumentStore:
    """The task files that pages have opened; `followed` is told of each edit's file and steps, in the edit's thread."""

    def __init__(self, folder: ProjectFolder, followed: Callable[[str, tuple[Step, ...]], object] = lambda *_: None):
        self.folder, self._followed = folder, followed
        self._sheets: dict[str, OpenDocument] = {}
        self._lock = RLock()

    def revisions(self) -> dict[str, int]:
        """Return the revision of each open file."""
        return {path: opened.revision for path, opened in list(self._sheets.items())}

    @contextmanager
    def held(self, path: str) -> Iterator[OpenDocument]:
        """Hold a task file, opened where it isn't yet, while something is read from it or changed.

        What isn't saved afterwards is kept.

        Raises:
            OutsideProjectError: the path leads elsewhere.
            DocumentError: there is no such file, or it isn't text.
        """
        with self._lock:
            opened = self._open(path)
            before = opened.revision
            yield opened
            if opened.revision != before:
                opened.keep_unsaved()

    def _open(self, path: str) -> OpenDocument:
        if path not in self._sheets:
            file = self.folder.task_file(path)
            layout = layout_path(file)
            kept = recovery_of(self.folder.journal.parent / "unsaved", path)
            opened = OpenDocument(TextFile(file, path), TextFile(layout, layout.name), kept)
            opened.followed = lambda steps: self._followed(path, steps)
            self._sheets[path] = opened
        return self._sheets[path]

    def create(self, path: str, text: str | None = None) -> None:
        """Make a new task file; without a text it does nothing yet.

        Raises:
            OutsideProjectError: the path leads elsewhere, or isn't one of a task file.
            DocumentError: a file is there, or the text isn't a task.
        """
        with self._lock:
            file = self.folder.new_task_file(path)
            if text is None:
                try:
                    task = {"grip": 1, "name": file.stem, "root": {"kind": "sequence", "children": {}}}
                    text = dumps(Task.model_validate(task))
                except ValueError as error:
                    raise DocumentError(f"{file.stem!r} isn't a name for a task", file.stem) from error
            read_text(text, path)
            TextFile(file, path).write(text)
            recovery_of(self.folder.journal.parent / "unsaved", path).remove()
            self._sheets.pop(path, None)

    def meant(self, command: AnyCommand, document: Document) -> AnyCommand:
        """Return the edit that a command comes to here; an `extract` makes its file, which stays where it is undone.

        Raises:
            EditError: it can't be carried out.
            HandoverError: it can, but somebody could tell; `approximate` does it all the same.
        """
        if not isinstance(command, Convert | Extract | Inline | Group):
            return command
        catalog = catalog_of(self.folder)[0]
        if not isinstance(command, Extract):
            return expanded(command, document.task, catalog)
        part = extracted(command, document, catalog)
        self.create(part.file, part.text)
        return part.edit
