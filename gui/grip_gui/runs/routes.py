"""The server's routes about the project, its tasks, and runs: start, control, breakpoints, who holds control."""

from __future__ import annotations

from typing import Annotated, get_args

from fastapi import APIRouter, Path, WebSocket

from grip_bt.app.wiring.parts import RobotKind
from grip_bt.base.errors import GripError
from grip_bt.base.yaml.tree import read_file
from grip_gui.editing.projection import kind_views
from grip_gui.editing.routes import DocumentStore
from grip_gui.editing.views import view_of_text
from grip_gui.project import ProjectFolder
from grip_gui.runs.begin_at import mocks_before
from grip_gui.runs.journal import JournalRuns
from grip_gui.runs.run_control import RunControl
from grip_gui.runs.stream import ClientConnection
from grip_gui.runs.values import cloud_view
from grip_gui.wire import runs as wire
from grip_gui.wire.task import ProjectView

_Number = Annotated[int, Path(ge=1, le=2**53)]
_ROBOTS = [str(kind) for kind in get_args(RobotKind)]


def make_router(
    folder: ProjectFolder, control: RunControl, source: JournalRuns, selected: str | None, edits: DocumentStore
) -> APIRouter:
    """Return the routes below `/api`."""
    api = APIRouter(prefix="/api")

    @api.get("/project")
    def project() -> ProjectView:
        root, tasks = folder.folder, folder.tasks()
        return ProjectView(
            name=root.name, folder=str(root), tasks=tasks, kinds=kind_views(), robots=_ROBOTS, selected=selected
        )

    api.get("/runs")(source.runs)

    @api.get("/runs/{run}")
    def run(run: str) -> wire.RunView:
        record = source.run(run)
        return wire.RunView(run=record, task=view_of_text(folder, source.task_text(run), record.task_path))

    @api.get("/runs/{run}/values/{seq}")
    def value(run: str, seq: _Number) -> wire.ValueView:
        return source.value(run, seq)

    @api.get("/runs/{run}/values/{seq}/cloud")
    def cloud(run: str, seq: _Number) -> wire.CloudView:
        return cloud_view(source.raw(run, seq))

    @api.websocket("/socket")
    async def socket(websocket: WebSocket, page: wire.PageId = "") -> None:
        await websocket.accept()
        await ClientConnection(websocket, control, source, edits.revisions, page).serve()

    _add_runs(api, folder, control)
    return api


def _add_runs(api: APIRouter, folder: ProjectFolder, control: RunControl) -> None:
    """Add what starts and controls runs."""

    @api.get("/session")
    async def session() -> wire.SessionView | None:
        return control.view

    @api.post("/session", status_code=201)
    async def start(request: wire.StartRun) -> wire.SessionView:
        file = folder.task_file(request.task)
        return await control.start(request.task, file, _options(folder, request), request.page, request.run_to)

    @api.post("/session/control")
    async def command(request: wire.Control) -> wire.SessionView:
        return await control.command(request)

    @api.get("/desk")
    async def shared() -> wire.SharedState:
        return control.shared_state

    @api.post("/breakpoints")
    async def breakpoints(request: wire.BreakpointsRequest) -> wire.SharedState:
        folder.task_file(request.task)
        try:
            return control.set_breakpoints(request.task, request.breakpoints, request.page)
        except OSError as error:
            raise GripError(f"the breakpoints can't be kept: {error}") from error

    @api.post("/lease")
    async def lease(request: wire.ControlRequest) -> wire.SharedState:
        if request.take:
            control.presence.take(request.page, request.over)
        else:
            control.presence.give(request.page)
        return control.shared_state


def _options(folder: ProjectFolder, request: wire.StartRun) -> wire.RunOptions:
    fields = request.model_dump(include=set(wire.RunOptions.model_fields))
    if request.begin_at:
        view = view_of_text(folder, read_file(folder.task_file(request.task)), request.task)
        fields["mocks"] = mocks_before(view, request.begin_at) | request.mocks
    return wire.RunOptions(**fields)
