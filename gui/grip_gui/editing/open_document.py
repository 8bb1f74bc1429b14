"""One open task file: its history, the text that isn't a task yet, its layout, and what is on disk."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple, TypeAlias

from grip_bt.base.errors import DocumentError, EditError
from grip_bt.task import Task, read_text, walk
from grip_bt.task.document import Document
from grip_bt.task.edit import AnyCommand, Group, History, command_of, path_after, rewrite
from grip_bt.task.edit.history import history_path, load_history, save_history
from grip_bt.task.edit.steps import Remark, Shift, Step, path_of
from grip_gui.editing.files import ChangedOnDiskError, StaleEditError, TextFile, UnfinishedTextError
from grip_gui.editing.layout import Layout, read_layout, write_layout

log = logging.getLogger(__name__)
KEPT = 1000  # so many edits back an edit of a page that was late is still carried over
FROM_DISK = "take the file's text"
RECOVERED = "recover unsaved changes"
Meaning: TypeAlias = Callable[[AnyCommand, Document], AnyCommand]
"""What a command comes to in a document, where that takes more than the document itself."""


class _AppliedEdit(NamedTuple):
    """What the edit that led to a revision did, and to which task."""

    revision: int
    before: Task | None
    steps: tuple[Step, ...]


class OpenDocument:
    """A task file that is open, with the file of its layout, and where what isn't saved is kept.

    A text that isn't a task is kept beside the last good task (`draft`) until it is one again; it is saved as it
    is, and nothing drawn is changed meanwhile. `revision` grows with whatever changes what a page shows. `followed`
    is told what each edit did.

    Raises:
        DocumentError: the file can't be read.
    """

    def __init__(self, file: TextFile, layout: TextFile, recovery: TextFile):
        self.file, self._layout_file, self._recovery = file, layout, recovery
        self.history: History | None = None
        self.draft: str | None = None
        self.followed: Callable[[tuple[Step, ...]], object] = lambda _: None
        self.revision = 1
        self._dropped: str | None = None
        self._past: list[_AppliedEdit] = []
        self._task: Task | None = None
        self._first_layout = Layout()
        self._layouts: dict[int, Layout] = {}
        self._history_file = history_path(file.path)
        text = file.read()
        try:
            self._begin(text)
        except DocumentError:
            self.draft = text
        self._saved = text
        self._saved_layout = write_layout(self.layout)
        if recovery.path.exists():
            try:
                left = json.loads(recovery.read())
                self._put_text(str(left["text"]), RECOVERED)
                self.file.known = str(left["known"])  # where the file has changed since, a save asks first
            except (DocumentError, ValueError, KeyError, TypeError) as error:
                log.warning("the unsaved text of %s can't be read: %s", file.name, error)

    def keep_unsaved(self) -> None:
        """Keep a copy of what isn't saved, or forget the copy of what is; that it can't be kept stops no edit."""
        if self.text == self._saved and not self.file.change():
            self._recovery.remove()
            return
        try:
            self._recovery.write(json.dumps({"known": self.file.known, "text": self.text}))
        except DocumentError as error:
            log.warning("unsaved changes aren't kept: %s", error)

    def _begin(self, text: str) -> None:
        """Go on with the history that was kept beside the file; begin a new one where there is none."""
        document = read_text(text, self.file.name)
        try:
            self.history = load_history(self._history_file, document)
        except DocumentError as error:
            log.warning("%s", error)
            self.history = History(document)
        self._task = document.task
        try:
            self._first_layout = read_layout(self._layout_file.read()) if self._layout_file.path.exists() else Layout()
        except DocumentError:
            self._first_layout = Layout()
        self._layouts = {self.history.at.number: self._first_layout}

    # --- how it is --------------------------------------------------------------------------------------------------

    @property
    def document(self) -> Document | None:
        """The task that the text is now; None while it is none."""
        return self.history.document if self.history is not None and self.draft is None else None

    @property
    def text(self) -> str:
        """The text as it is now, a task or not."""
        if self.draft is not None:
            return self.draft
        assert self.history is not None, "an open document has a history or a draft"
        return self.history.document.text

    @property
    def layout(self) -> Layout:
        """The pinned positions at this moment."""
        return self._layouts.get(self.history.at.number, self._first_layout) if self.history else Layout()

    @property
    def saved(self) -> bool:
        """Whether the file has what is here."""
        return self.text == self._saved and write_layout(self.layout) == self._saved_layout

    @property
    def can_undo(self) -> bool:
        """Whether something can be undone; a draft can be dropped where there is a task to go back to."""
        return self.history is not None and (self.draft is not None or self.history.can_undo)

    @property
    def can_redo(self) -> bool:
        """Whether something was undone here."""
        return self.draft is None and (self._dropped is not None or bool(self.history and self.history.can_redo))

    # --- edits ------------------------------------------------------------------------------------------------------

    def do(self, command: AnyCommand, base: int, meaning: Meaning = lambda command, _: command) -> None:
        """Carry out a command, or what it comes to in the document as it is now, that was made on the revision `base`.

        Raises:
            EditError: it can't be carried out.
            StaleEditError: what it is about is gone since.
            UnfinishedTextError: the text isn't a task.
        """
        history = self._settled()
        before, edited = self.layout, history.do(meaning(rebased(command, self._since(base)), history.document))
        self._dropped = None
        self._enter(before, edited.steps)

    def pin(self, view: str, positions: dict[str, tuple[float, float] | None], title: str) -> None:
        """Pin nodes at positions of a view [px], or unpin them (None); it is undone like every edit."""
        history = self._settled()
        layout = self.layout
        for path, spot in positions.items():
            layout = layout.pin(view, path, spot)
        history.do(Group(title=title, commands=()))
        self._enter(layout, ())

    def write(self, text: str, base: int | None) -> None:
        """Take a text that a person has typed on the state `base` (None: on any); it may be no task yet.

        Raises:
            StaleEditError: something else has changed since, so that the text would take it back.
        """
        if base not in (None, self.revision):
            raise StaleEditError(
                f"{self.file.name} was changed elsewhere while you were typing (revision {self.revision}, you have "
                f"{base}); your text is still in the text view: take the new text, or put yours over it"
            )
        self._put_text(text)

    def _put_text(self, text: str, title: str = "edit the text") -> None:
        if text == self.text:
            return
        self._dropped = None
        try:
            if self.history is None:
                self._begin(text)
            assert self.history is not None
            before, document = self.layout, self.history.document
            steps: tuple[Step, ...] = ()
            if text != document.text:
                steps = self.history.do(rewrite(document, text, title)).steps
            self._enter(before, steps)
        except (DocumentError, EditError):
            self.draft = text
            self.revision += 1
            return
        self.draft = None

    def undo(self) -> None:
        """Go to the moment before, if there is one; where there is a draft, drop it (redo brings it back)."""
        if self.draft is not None and self.history is not None:
            self._dropped, self.draft = self.draft, None
            self._enter(self.layout, ())
            return
        self._enter(self.layout, self._settled().undo())

    def redo(self, number: int | None = None) -> None:
        """Go to the moment that was left last, or to the one of this number that was made from here."""
        history = self._settled()
        if self._dropped is not None and number is None:
            self.draft, self._dropped = self._dropped, None
            self.revision += 1
            return
        self._enter(self.layout, history.redo(number))

    def go(self, number: int) -> None:
        """Go to any moment of any branch."""
        self._enter(self.layout, self._settled().go(number))

    def _settled(self) -> History:
        """Return the history, unless a draft is in the way."""
        if self.draft is not None or self.history is None:
            try:
                read_text(self.text, self.file.name)
                why = "it differs from what it says"
            except DocumentError as error:
                why = str(error)
            raise UnfinishedTextError(
                f"{self.file.name}: the text is not a valid task ({why}); fix it in the text view, or undo"
            )
        return self.history

    def _since(self, base: int) -> Iterable[tuple[Step, ...]]:
        if base == self.revision:
            return ()
        if not self._past or not self._past[0].revision - 1 <= base < self.revision:
            raise StaleEditError(f"{self.file.name}: revision {base} is unknown here; the page now shows the newest")
        return [past.steps for past in self._past if past.revision > base]

    def moved_since(self, revision: int) -> dict[str, str]:
        """Return where nodes are that edits since a revision have moved."""
        past = [each for each in self._past if each.revision > revision]
        if self.history is None or not past or past[0].before is None:
            return {}
        there = {path for path, _ in walk(self.history.document.task.root)}
        steps = [step for each in past for step in each.steps]
        moved = {path: path_after(path, steps) for path, _ in walk(past[0].before.root) if path not in there}
        return {path: now for path, now in moved.items() if now in there}

    def _enter(self, before: Layout, steps: tuple[Step, ...]) -> None:
        """Note that the document has changed; a moment whose layout isn't known gets what the one before becomes."""
        assert self.history is not None
        self.revision += 1
        self._layouts.setdefault(self.history.at.number, before.after(steps))
        self.followed(steps)
        self._past.append(_AppliedEdit(self.revision, self._task, steps))
        self._task = self.history.document.task
        del self._past[:-KEPT]

    # --- the file ---------------------------------------------------------------------------------------------------

    def save(self, over: bool = False) -> None:
        """Write the file, and the layout's file; with `over` also where somebody else has changed the file since.

        Raises:
            ChangedOnDiskError: somebody else has.
        """
        change = self.file.change()
        if change and not over:
            raise ChangedOnDiskError(self.file.name, change)
        layout = write_layout(self.layout)
        if self.text != self._saved or change:
            self.file.write(self.text)
        if layout != self._saved_layout and self.history is not None:
            self._layout_file.write(layout) if layout else self._layout_file.remove()
        self._saved, self._saved_layout = self.text, layout
        if self.history is not None and self.draft is None:
            try:
                save_history(self.history, self._history_file)
            except DocumentError as error:  # that keeps nobody from saving
                log.warning("the history of %s isn't kept: %s", self.file.name, error)
        self.revision += 1

    def follow_disk(self) -> None:
        """Reload from the file where it has changed and nothing here would be lost by it."""
        if self.saved and self.file.change() == "changed":
            self.take_from_disk()

    def take_from_disk(self) -> None:
        """Reload from the file as an edit, so that undo brings back what was here."""
        text = self.file.read()
        if self.draft is not None and self.history is not None:
            self.undo()
        self._put_text(text, FROM_DISK)
        self._saved = text
        self.revision += 1


def rebased(command: AnyCommand, since: Iterable[tuple[Step, ...]]) -> AnyCommand:
    """Return a command with the paths of its nodes as they are after some edits.

    Raises:
        StaleEditError: a node that it is about is gone, what it sets was set, or it fits one state of a task alone.
    """
    taken = tuple(step for steps in since for step in steps)
    return command_of(_moved(command.model_dump(mode="json"), taken)) if taken else command


def _moved(command: dict[str, Any], steps: tuple[Step, ...]) -> dict[str, Any]:
    if command["do"] in ("patch", "convert"):  # what was looked at is one state alone
        raise StaleEditError("the task was just changed elsewhere; check it, then try again")
    moved = {key: _where(value, steps) if key in ("path", "parent") else value for key, value in command.items()}
    if command["do"] in ("set", "unset") and any(_sets(step, moved["path"], command["key"]) for step in steps):
        raise StaleEditError(
            f"{' '.join(command['key'])} of {moved['path'] or 'the task'} was just set elsewhere; "
            "nothing was changed: look at what it is now, then set it again"
        )
    if "paths" in command:
        moved["paths"] = [_where(path, steps) for path in command["paths"]]
    if "commands" in command:
        moved["commands"] = [_moved(part, steps) for part in command["commands"]]
    return moved


def _sets(step: Step, path: str, key: Sequence[str]) -> bool:
    """Tell whether a step has changed a key of a node."""
    if isinstance(step, Shift | Remark):
        return False
    at, inner = step.at[: len(step.at) - len(key) + 1], (*step.at[len(step.at) - len(key) + 1 :], step.key)
    return inner == tuple(key) and path_of(at) == path


def _where(path: str, steps: tuple[Step, ...]) -> str:
    now = path_after(path, steps) if path else path
    if now is None:
        raise StaleEditError(f"{path} was removed elsewhere while you were editing it; nothing was changed")
    return now
