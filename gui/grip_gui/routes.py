"""The server's questions and answers about the project, its tasks and the runs of its journal."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, WebSocket

from grip_bt.base.errors import UnknownNameError
from grip_gui.documents import task_view, view_of_text
from grip_gui.editing import EditDesk
from grip_gui.journal import RunSource
from grip_gui.messages import ProjectView, TaskView
from grip_gui.project import ProjectFolder
from grip_gui.run_desk import RunDesk
from grip_gui.run_messages import CloudView, PageId, RunRecord, RunView, ValueView
from grip_gui.run_routes import robots
from grip_gui.stream import Viewer
from grip_gui.values import cloud_view


def make_router(
    folder: ProjectFolder, desk: RunDesk, source: RunSource, selected: str | None, edits: EditDesk
) -> APIRouter:
    """Return the routes below `/api`."""
    api = APIRouter(prefix="/api")

    @api.get("/project")
    def project() -> ProjectView:
        return ProjectView(
            name=folder.name, folder=str(folder.folder), tasks=folder.tasks(), robots=robots(), selected=selected
        )

    @api.get("/task")
    def task(path: str) -> TaskView:
        return task_view(folder, path)

    @api.get("/runs")
    def runs() -> list[RunRecord]:
        return source.runs()

    @api.get("/runs/{run}")
    def run(run: str) -> RunView:
        record = source.run(run)
        if record is None:
            raise UnknownNameError("run", run, (r.id for r in source.runs()[:10]))
        return RunView(run=record, task=view_of_text(folder, source.task_text(run), record.task_path))

    @api.get("/runs/{run}/values/{seq}")
    def value(run: str, seq: Annotated[int, Path(ge=1, le=2**53)]) -> ValueView:
        return source.value(run, seq)

    @api.get("/runs/{run}/values/{seq}/cloud")
    def cloud(run: str, seq: Annotated[int, Path(ge=1, le=2**53)]) -> CloudView:
        return cloud_view(source.raw(run, seq))

    @api.websocket("/socket")
    async def socket(websocket: WebSocket, page: PageId = "") -> None:
        await websocket.accept()
        await Viewer(websocket, desk, source, edits.revisions, page).serve()

    return api
