"""Questions and wishes about the files that put a project together."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from fastapi import APIRouter

from grip_bt.base.errors import GripError
from grip_gui.processes import Prober
from grip_gui.project import ProjectFolder
from grip_gui.runs.journal import JournalRuns
from grip_gui.setup.desk import SetupDesk
from grip_gui.setup.importing import import_file
from grip_gui.setup.interfaces import look_at, make
from grip_gui.setup.named import keep_value
from grip_gui.setup.options import names_of
from grip_gui.wire.setup import (
    ImportView,
    ImportWish,
    InterfaceView,
    InterfaceWish,
    NamesView,
    ProbeView,
    ProbeWish,
    RecordWish,
    SetupChange,
    SetupList,
    SetupSave,
    SetupText,
    SetupView,
)


def make_setup_router(
    folder: ProjectFolder, prober: Prober, source: JournalRuns, changed: Callable[[], None]
) -> APIRouter:
    """Return the routes below `/api/setup`.

    Args:
        folder: the project.
        prober: tries one thing at a time.
        source: where values of runs are read.
        changed: called in the event loop when the project's nodes may be others.
    """
    api = APIRouter(prefix="/api/setup")
    desk = SetupDesk(folder)

    @api.get("/files")
    def files() -> SetupList:
        return desk.files()

    @api.get("/file")
    def file(path: str) -> SetupView:
        return desk.open(path)

    @api.get("/names")
    def names() -> NamesView:
        return NamesView(places=names_of(folder.folder))

    @api.post("/check")
    def check(wish: SetupText) -> SetupView:
        return desk.check(wish.path, wish.text)

    @api.post("/change")
    def change(wish: SetupChange) -> SetupView:
        return desk.change(wish)

    @api.post("/save")
    async def save(wish: SetupSave) -> SetupView:
        view = await asyncio.to_thread(desk.save, wish)
        changed()
        return view

    @api.post("/probe")
    async def probe(wish: ProbeWish) -> ProbeView:
        view = await prober.probe(wish)
        changed()
        return view

    @api.post("/interface")
    async def interface(wish: InterfaceWish) -> InterfaceView:
        if not wish.create:
            return await asyncio.to_thread(look_at, folder, wish)
        view, home = await asyncio.to_thread(make, folder, wish)
        generated = await prober.run(("component", "add", str(home)))
        changed()
        if not generated.ok:
            raise GripError(f"{view.path} was written, but its node can't be generated:\n{generated.output}")
        return view.model_copy(update={"output": generated.output})

    @api.post("/import")
    async def bring(wish: ImportWish) -> ImportView:
        view = await import_file(folder, prober, wish)
        changed()
        return view

    @api.post("/record")
    async def keep(wish: RecordWish) -> SetupView:
        path = await asyncio.to_thread(lambda: keep_value(folder, wish.name, source.raw(wish.run, wish.seq)))
        return await asyncio.to_thread(desk.open, path)

    return api
