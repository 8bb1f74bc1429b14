"""Questions and wishes about the files that put a project together."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from fastapi import APIRouter

from grip_bt.base.errors import GripError
from grip_gui.journal import RunSource
from grip_gui.project import ProjectFolder
from grip_gui.setup import SetupDesk
from grip_gui.setup.importing import import_file
from grip_gui.setup.interfaces import look_at, make
from grip_gui.setup.options import names_of
from grip_gui.setup.probes import Prober
from grip_gui.setup.recording import record
from grip_gui.setup_messages import (
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


def make_setup_router(folder: ProjectFolder, source: RunSource, changed: Callable[[], None]) -> APIRouter:
    """Return the routes below `/api/setup`.

    Args:
        folder: the project.
        source: where values of runs are read.
        changed: called in the event loop when the project's nodes may be others.
    """
    api = APIRouter(prefix="/api/setup")
    desk, prober = SetupDesk(folder), Prober(folder)

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
        path = await asyncio.to_thread(lambda: record(folder, wish.name, source.raw(wish.run, wish.seq)))
        return await asyncio.to_thread(desk.open, path)

    return api
