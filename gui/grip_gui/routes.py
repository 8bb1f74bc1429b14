"""The server's questions and answers: project, tasks, runs, and the run under way."""

from __future__ import annotations

from fastapi import APIRouter, WebSocket

from grip_bt.errors import GripError, UnknownNameError

from .documents import task_view, view_of_text
from .editing import EditDesk
from .journal import RunSource
from .launcher import RunOptions
from .messages import Control, ProjectView, RunRecord, RunView, SessionView, StartRun, TaskView
from .project import ProjectFolder
from .session import RunDesk
from .stream import Viewer

ROBOTS = ["sim", "fake"]


def make_router(
    folder: ProjectFolder, desk: RunDesk, source: RunSource, selected: str | None, edits: EditDesk
) -> APIRouter:
    """Return the routes below `/api`."""
    api = APIRouter(prefix="/api")

    @api.get("/project")
    def project() -> ProjectView:
        return ProjectView(
            name=folder.name, folder=str(folder.folder), tasks=folder.tasks(), robots=ROBOTS, selected=selected
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

    @api.get("/session")
    async def session() -> SessionView | None:
        return desk.view

    @api.post("/session", status_code=201)
    async def start(wish: StartRun) -> SessionView:
        options = RunOptions(robot=wish.robot, target=wish.target, seed=wish.seed, pace=wish.pace)
        try:
            return await desk.start(wish.task, folder.task_file(wish.task), options)
        except OSError as error:
            raise GripError(f"the run's process can't be started: {error}") from error

    @api.post("/session/control")
    async def control(wish: Control) -> SessionView:
        return await desk.command(wish.command)

    @api.websocket("/socket")
    async def socket(websocket: WebSocket) -> None:
        await websocket.accept()
        await Viewer(websocket, desk, source, edits.revisions).serve()

    return api
