"""All open task files of a project, under one lock, and the questions and requests about them.

All work is done in threads; the pages are told afterwards.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import RLock
from typing import Annotated

from fastapi import APIRouter, Query, Response

from grip_bt.base.errors import DocumentError, EditError
from grip_bt.compilers.restructure import expanded, extracted
from grip_bt.task import Task, dumps, read_text
from grip_bt.task.document import Document
from grip_bt.task.edit import AnyCommand, ChangeKind, Convert, Extract, Group, command_of
from grip_bt.task.edit.steps import Step
from grip_gui.editing.conversion import conversion_view, forms_view
from grip_gui.editing.files import StaleEditError, TextFile, recovery_of
from grip_gui.editing.layout import layout_path
from grip_gui.editing.open_document import OpenDocument
from grip_gui.editing.projection import catalog_view
from grip_gui.editing.views import (
    catalog_of,
    check_expression,
    comment_view,
    document_view,
    parts_view,
    places_view,
    problems_view,
)
from grip_gui.project import ProjectFolder
from grip_gui.wire import editing as wire


class DocumentStore:
    """The task files that pages have opened; `followed` is told of each edit's file and steps, in the edit's thread."""

    def __init__(self, folder: ProjectFolder, followed: Callable[[str, tuple[Step, ...]], object] = lambda *_: None):
        self.folder, self._followed = folder, followed
        self._opened: dict[str, OpenDocument] = {}
        self._lock = RLock()

    def revisions(self) -> dict[str, int]:
        """Return the revision of each open file."""
        return {path: opened.revision for path, opened in list(self._opened.items())}

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
        if path not in self._opened:
            file = self.folder.task_file(path)
            layout = layout_path(file)
            kept = recovery_of(self.folder.journal.parent / "unsaved", path)
            opened = OpenDocument(TextFile(file, path), TextFile(layout, layout.name), kept)
            opened.followed = lambda steps: self._followed(path, steps)
            self._opened[path] = opened
        return self._opened[path]

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
            self._opened.pop(path, None)

    def meant(self, command: AnyCommand, document: Document) -> AnyCommand:
        """Return the edit that a command comes to here; an `extract` makes its file, which stays where it is undone.

        Raises:
            EditError: it can't be carried out.
            HandoverError: it can, but somebody could tell; `approximate` does it all the same.
        """
        if not isinstance(command, ChangeKind | Convert | Extract | Group):
            return command
        catalog = catalog_of(self.folder)[0]
        if not isinstance(command, Extract):
            return expanded(command, document.task, catalog)
        part = extracted(command, document, catalog)
        self.create(part.file, part.text)
        return part.edit


def make_edit_router(documents: DocumentStore, notify: Callable[[], None]) -> APIRouter:
    """Return the routes below `/api` that read and change documents; `notify`, in the event loop, tells the pages."""
    api = APIRouter(prefix="/api")
    _add_questions(api, documents)
    _add_requests(api, documents, notify)
    return api


def _add_questions(api: APIRouter, documents: DocumentStore) -> None:
    folder = documents.folder

    @api.get("/catalog")
    def catalog() -> wire.CatalogView:
        found, error = catalog_of(folder)
        files = [entry.path for entry in folder.tasks()]
        return catalog_view(found, files, error.message if error else "")

    @api.get("/document/forms")
    def forms(path: str) -> wire.FormsView:
        with documents.held(path) as opened:
            find = forms_view(opened, catalog_of(folder)[0])
        return find()

    @api.get("/document/problems")
    def problems(path: str) -> wire.ProblemsView:
        with documents.held(path) as opened:
            find = problems_view(folder, opened)
        return find()

    @api.get("/document/places")
    def places(path: str) -> wire.PlacesView:
        with documents.held(path) as opened:
            return places_view(opened)

    @api.get("/document/comment")
    def comment(path: str, node: str) -> wire.CommentView:
        with documents.held(path) as opened:
            return comment_view(opened, node)

    @api.get("/document/parts")
    def parts(path: str, node: Annotated[list[str], Query(max_length=1000)]) -> list[wire.Part]:
        with documents.held(path) as opened:
            return parts_view(opened, node)

    @api.get("/document/conversion")
    def conversion(path: str, node: str, form: wire.Form) -> wire.ConversionView:
        with documents.held(path) as opened:
            find = conversion_view(opened, catalog_of(folder)[0], node, form)
        return find()

    @api.post("/document/expression")
    def expression(request: wire.ExpressionRequest) -> list[str]:
        with documents.held(request.path) as opened:
            return check_expression(folder, opened, request)


def _add_requests(api: APIRouter, documents: DocumentStore, notify: Callable[[], None]) -> None:
    async def change(
        path: str, work: Callable[[OpenDocument], object], since: int | None, status: int = 200
    ) -> Response:
        def changed() -> str:
            with documents.held(path) as opened:
                work(opened)
                return document_view(documents.folder, opened, since).model_dump_json()

        body = await asyncio.to_thread(changed)
        notify()
        return Response(body, status, media_type="application/json")

    @api.get("/document")
    async def document(path: str, since: int | None = None) -> Response:
        return await change(path, OpenDocument.follow_disk, since)

    @api.post("/document/edit")
    async def edit(request: wire.EditRequest, since: int | None = None) -> Response:
        command = command_of(request.command)
        return await change(request.path, lambda opened: opened.do(command, request.base, documents.meant), since)

    @api.post("/document/text")
    async def text(request: wire.TextRequest, since: int | None = None) -> Response:
        base = None if request.over else request.base
        return await change(request.path, lambda opened: opened.write(request.text, base), since)

    @api.post("/document/step")
    async def step(request: wire.StepRequest, since: int | None = None) -> Response:
        return await change(request.path, lambda opened: _step(opened, request), since)

    @api.post("/document/pin")
    async def pin(request: wire.PinRequest, since: int | None = None) -> Response:
        title = f"place {next(iter(request.positions), '')}"
        return await change(request.path, lambda opened: opened.pin(request.view, request.positions, title), since)

    @api.post("/document/save")
    async def save(request: wire.SaveRequest, since: int | None = None) -> Response:
        return await change(request.path, lambda opened: opened.save(request.over), since)

    @api.post("/document/disk")
    async def disk(request: wire.OfDocument, since: int | None = None) -> Response:
        return await change(request.path, OpenDocument.take_from_disk, since)

    @api.post("/document/new")
    async def new(request: wire.NewTask, since: int | None = None) -> Response:
        await asyncio.to_thread(documents.create, request.path, request.text)
        return await change(request.path, lambda _: None, since, 201)


def _step(opened: OpenDocument, request: wire.StepRequest) -> None:
    if request.base != opened.revision:
        raise StaleEditError("the task was just changed elsewhere; check it, then undo or redo again")
    if request.step == "undo":
        opened.undo()
    elif request.step == "redo":
        opened.redo(request.number)
    elif request.number is None:
        raise EditError("", "name the state to go to")
    else:
        opened.go(request.number)
