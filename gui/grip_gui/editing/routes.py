"""Questions and wishes about task files under edit. All work is done in threads; the pages are told afterwards."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Annotated, TypeVar

from fastapi import APIRouter, Query, Response
from pydantic import ValidationError

from grip_bt.base.errors import EditError
from grip_bt.task.edit import AnyCommand, command_of
from grip_gui.editing.conversion import conversion_view, convert, forms_view
from grip_gui.editing.document_store import EditDesk, carry_out, takes_catalogue
from grip_gui.editing.files import StaleEditError
from grip_gui.editing.open_document import Sheet
from grip_gui.editing.palette import catalog_view
from grip_gui.editing.views import check_expression, comment_view, document_view, parts_view, places_view, problems_view
from grip_gui.view.documents import catalog_of
from grip_gui.wire.editing import (
    CatalogView,
    CommentView,
    ConversionView,
    ConvertWish,
    DiskWish,
    EditWish,
    ExpressionView,
    ExpressionWish,
    Form,
    FormsView,
    NewTask,
    PartsView,
    PinWish,
    PlacesView,
    ProblemsView,
    SaveWish,
    StepWish,
    TextWish,
)

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
            find = forms_view(sheet, catalog_of(folder)[0])
        return find()

    @api.get("/document/problems")
    def problems(path: str) -> ProblemsView:
        with desk.reading(path) as sheet:
            find = problems_view(folder, sheet)
        return find()

    @api.get("/document/places")
    def places(path: str) -> PlacesView:
        with desk.reading(path) as sheet:
            return places_view(sheet)

    @api.get("/document/comment")
    def comment(path: str, node: str) -> CommentView:
        with desk.reading(path) as sheet:
            return comment_view(sheet, node)

    @api.get("/document/parts")
    def parts(path: str, node: Annotated[list[str], Query(max_length=1000)]) -> PartsView:
        with desk.reading(path) as sheet:
            return parts_view(sheet, node)

    @api.get("/document/conversion")
    def conversion(path: str, node: str, form: Form, approximate: bool = False) -> ConversionView:
        with desk.reading(path) as sheet:
            find = conversion_view(sheet, catalog_of(folder)[0], node, form, approximate)
        return find()

    @api.post("/document/expression")
    def expression(wish: ExpressionWish) -> ExpressionView:
        with desk.reading(wish.path) as sheet:
            return check_expression(folder, sheet, wish)


def _add_wishes(api: APIRouter, desk: EditDesk, notify: Callable[[], None]) -> None:
    async def change(path: str, work: Callable[[Sheet], object], since: int | None, status: int = 200) -> Response:
        def changed() -> str:
            with desk.changing(path) as sheet:
                work(sheet)
                return document_view(desk.folder, sheet, since).model_dump_json()

        body = await asyncio.to_thread(changed)
        notify()
        return Response(body, status, media_type="application/json")

    @api.get("/document")
    async def document(path: str, since: int | None = None) -> Response:
        return await change(path, Sheet.follow_disk, since)

    @api.post("/document/edit")
    async def edit(wish: EditWish, since: int | None = None) -> Response:
        command = understood(wish.command)
        if not takes_catalogue(command):
            return await change(wish.path, lambda sheet: sheet.do(command, wish.base), since)
        found = catalog_of(desk.folder)[0]
        return await change(wish.path, lambda sheet: carry_out(desk, sheet, command, wish.base, found), since)

    @api.post("/document/convert")
    async def convert_container(wish: ConvertWish, since: int | None = None) -> Response:
        found = catalog_of(desk.folder)[0]
        return await change(wish.path, lambda sheet: convert(sheet, found, wish), since)

    @api.post("/document/text")
    async def text(wish: TextWish, since: int | None = None) -> Response:
        return await change(
            wish.path, lambda sheet: sheet.write(wish.text, sheet.revision if wish.over else wish.base), since
        )

    @api.post("/document/step")
    async def step(wish: StepWish, since: int | None = None) -> Response:
        return await change(wish.path, lambda sheet: _step(sheet, wish), since)

    @api.post("/document/pin")
    async def pin(wish: PinWish, since: int | None = None) -> Response:
        title = f"place {next(iter(wish.positions), '')}"
        return await change(wish.path, lambda sheet: sheet.pin(wish.view, wish.positions, title), since)

    @api.post("/document/save")
    async def save(wish: SaveWish, since: int | None = None) -> Response:
        return await change(wish.path, lambda sheet: sheet.save(wish.over), since)

    @api.post("/document/disk")
    async def disk(wish: DiskWish, since: int | None = None) -> Response:
        return await change(wish.path, Sheet.take_from_disk, since)

    @api.post("/document/new")
    async def new(wish: NewTask, since: int | None = None) -> Response:
        await asyncio.to_thread(desk.create, wish.path, wish.text)
        return await change(wish.path, lambda _: None, since, 201)


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
