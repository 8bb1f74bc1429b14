"""Questions and requests about the files that put a project together."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from fastapi import APIRouter

from grip_bt.base.errors import GripError
from grip_gui.processes import CommandRunner
from grip_gui.project import ProjectFolder
from grip_gui.runs.journal import JournalRuns
from grip_gui.setup.importing import import_file
from grip_gui.setup.interfaces import look_at, make
from grip_gui.setup.named import keep_value
from grip_gui.setup.options import names_of
from grip_gui.setup.settings_store import SettingsStore
from grip_gui.wire.setup import (
    CommandRequest,
    CommandResult,
    ImportRequest,
    ImportView,
    InterfaceRequest,
    InterfaceView,
    NamesView,
    RecordRequest,
    SetupChange,
    SetupList,
    SetupSave,
    SetupText,
    SetupView,
)


def make_setup_router(
    folder: ProjectFolder, runner: CommandRunner, source: JournalRuns, changed: Callable[[], None]
) -> APIRouter:
    """Return the routes below `/api/setup`.

    Args:
        folder: the project.
        runner: tries one thing at a time.
        source: where values of runs are read.
        changed: called in the event loop when the project's nodes may be others.
    """
    api = APIRouter(prefix="/api/setup")
    desk = SettingsStore(folder)

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
    def check(request: SetupText) -> SetupView:
        return desk.check(request.path, request.text)

    @api.post("/change")
    def change(request: SetupChange) -> SetupView:
        return desk.change(request)

    @api.post("/save")
    async def save(request: SetupSave) -> SetupView:
        view = await asyncio.to_thread(desk.save, request)
        changed()
        return view

    @api.post("/probe")
    async def probe(request: CommandRequest) -> CommandResult:
        view = await runner.probe(request)
        changed()
        return view

    @api.post("/interface")
    async def interface(request: InterfaceRequest) -> InterfaceView:
        if not request.create:
            return await asyncio.to_thread(look_at, folder, request)
        view, home = await asyncio.to_thread(make, folder, request)
        generated = await runner.run(("component", "add", str(home)))
        changed()
        if not generated.ok:
            raise GripError(f"{view.path} was written, but its node can't be generated:\n{generated.output}")
        return view.model_copy(update={"output": generated.output})

    @api.post("/import")
    async def bring(request: ImportRequest) -> ImportView:
        view = await import_file(folder, runner, request)
        changed()
        return view

    @api.post("/record")
    async def keep(request: RecordRequest) -> SetupView:
        path = await asyncio.to_thread(lambda: keep_value(folder, request.name, source.raw(request.run, request.seq)))
        return await asyncio.to_thread(desk.open, path)

    return api
