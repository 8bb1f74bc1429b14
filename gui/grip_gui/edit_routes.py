"""Questions and wishes about task files under edit. All work is done in threads; the pages are told afterwards."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Annotated, TypeVar

from fastapi import APIRouter, Query
from pydantic import ValidationError

from grip_bt.errors import EditError
from grip_bt.graph.edit import AnyCommand, command_of

from .documents import catalog_of
from .edit_messages import (
    CatalogView,
    ConversionView,
    ConvertWish,
    DiskWish,
    DocumentView,
    EditWish,
    ExpressionView,
    ExpressionWish,
    Form,
    FormsView,
    NewTask,
    PartsView,
    PinWish,
    PlacesView,
    SaveWish,
    StepWish,
    TextWish,
)
from .editing import EditDesk, Sheet, StaleEditError
from .editing.conversion import conversion_view, convert
from .editing.forms import forms_view
from .editing.palette import catalog_view
from .editing.views import check_expression, document_view, parts_view, places_view

T = TypeVar("T")


def make_edit_router(desk: EditDesk, notify: Callable[[], None]) -> APIRouter:
    """Return the routes below `/api` that read and change documents.

    Args:
        desk: the open files.
        notify: tells the pages that something has changed; called in the event loop.
    """
    api = APIRouter(prefix="/api")
    _add_questions(api, desk)
    _add_wishes(api, desk, notify)
    return api


def _add_questions(api: APIRouter, desk: EditDesk) -> None:
    folder = desk.folder

    @api.get("/catalog")
    def catalog() -> CatalogView:
        found, trouble = catalog_of(folder)
        files = [entry.path for entry in folder.tasks()]
        return catalog_view(found, files, trouble.message if trouble else "")

    @api.get("/document/forms")
    def forms(path: str) -> FormsView:
        with desk.reading(path) as sheet:
            return forms_view(sheet, catalog_of(folder)[0])

    @api.get("/document/places")
    def places(path: str) -> PlacesView:
        with desk.reading(path) as sheet:
            return places_view(sheet)

    @api.get("/document/parts")
    def parts(path: str, node: Annotated[list[str], Query(max_length=1000)]) -> PartsView:
        with desk.reading(path) as sheet:
            return parts_view(sheet, node)

    @api.get("/document/conversion")
    def conversion(path: str, node: str, form: Form) -> ConversionView:
        with desk.reading(path) as sheet:
            return conversion_view(sheet, catalog_of(folder)[0], node, form)

    @api.post("/document/expression")
    def expression(wish: ExpressionWish) -> ExpressionView:
        with desk.reading(wish.path) as sheet:
            return check_expression(folder, sheet, wish)


def _add_wishes(api: APIRouter, desk: EditDesk, notify: Callable[[], None]) -> None:
    async def change(path: str, work: Callable[[Sheet], object]) -> DocumentView:
        def changed() -> DocumentView:
            with desk.changing(path) as sheet:
                work(sheet)
                return document_view(desk.folder, sheet)

        view = await asyncio.to_thread(changed)
        notify()
        return view

    @api.get("/document")
    async def document(path: str) -> DocumentView:
        return await change(path, Sheet.follow_disk)

    @api.post("/document/edit")
    async def edit(wish: EditWish) -> DocumentView:
        command = understood(wish.command)
        return await change(wish.path, lambda sheet: sheet.do(command, wish.base))

    @api.post("/document/convert")
    async def convert_container(wish: ConvertWish) -> DocumentView:
        found = catalog_of(desk.folder)[0]
        return await change(wish.path, lambda sheet: convert(sheet, found, wish.node, wish.form, wish.base))

    @api.post("/document/text")
    async def text(wish: TextWish) -> DocumentView:
        return await change(wish.path, lambda sheet: sheet.write(wish.text, sheet.revision if wish.over else wish.base))

    @api.post("/document/step")
    async def step(wish: StepWish) -> DocumentView:
        return await change(wish.path, lambda sheet: _step(sheet, wish))

    @api.post("/document/pin")
    async def pin(wish: PinWish) -> DocumentView:
        title = f"place {next(iter(wish.positions), '')}"
        return await change(wish.path, lambda sheet: sheet.pin(wish.view, wish.positions, title))

    @api.post("/document/save")
    async def save(wish: SaveWish) -> DocumentView:
        return await change(wish.path, lambda sheet: sheet.save(wish.over))

    @api.post("/document/disk")
    async def disk(wish: DiskWish) -> DocumentView:
        return await change(wish.path, Sheet.take_from_disk)

    @api.post("/document/new", status_code=201)
    async def new(wish: NewTask) -> DocumentView:
        await asyncio.to_thread(desk.create, wish.path, wish.text)
        return await change(wish.path, lambda _: None)


def _step(sheet: Sheet, wish: StepWish) -> None:
    if wish.base != sheet.revision:
        raise StaleEditError("the task has just been changed elsewhere; look at it, then undo or redo again")
    if wish.step == "undo":
        sheet.undo()
    elif wish.step == "redo":
        sheet.redo(wish.number)
    elif wish.number is None:
        raise EditError("", "say to which moment")
    else:
        sheet.go(wish.number)


def understood(command: object) -> AnyCommand:
    """Return the command that a page has sent.

    Raises:
        EditError: it is none.
    """
    try:
        return command_of(command)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise EditError("", f"not a command: {where}: {first['msg']}") from None
    except RecursionError:
        raise EditError("", "not a command: nested too deeply") from None
