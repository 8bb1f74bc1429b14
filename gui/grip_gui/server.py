"""Puts the server together: the routes, the socket, the gate and the page."""

from __future__ import annotations

import asyncio
import logging
import os
import threading
import time
import webbrowser
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from secrets import token_urlsafe
from urllib.parse import urlencode

import uvicorn
from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from fastapi.staticfiles import StaticFiles
from starlette.exceptions import HTTPException

from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import DocumentError, GripError, HandoverError, MissingPartError, UnknownNameError
from grip_gui.editing.files import ChangedOnDiskError, StaleEditError, UnfinishedTextError
from grip_gui.editing.routes import DocumentStore, make_edit_router
from grip_gui.live.ros_client import RosClientProcess
from grip_gui.live.routes import make_live_router
from grip_gui.processes import CommandRunner
from grip_gui.project import OutsideProjectError, ProjectFolder
from grip_gui.runs.journal import JournalRuns
from grip_gui.runs.pages import ControlTakenError
from grip_gui.runs.routes import make_router
from grip_gui.runs.run_control import BusyError, Launch, RunControl, start_run
from grip_gui.security import HOST, Gate, listen
from grip_gui.setup.routes import make_setup_router
from grip_gui.wire.runs import RunOptions, StudySpan
from grip_gui.wire.task import ErrorBody

log = logging.getLogger(__name__)
STATIC = Path(__file__).parent / "static"
_REFUSALS: dict[type[GripError], tuple[int, str]] = {
    OutsideProjectError: (403, ""),
    UnknownNameError: (404, ""),
    DocumentError: (404, ""),
    BusyError: (409, ""),
    ControlTakenError: (409, "held"),
    StaleEditError: (409, "stale"),
    ChangedOnDiskError: (409, "disk"),
    UnfinishedTextError: (409, "unfinished"),
    HandoverError: (409, "approximate"),
}
"""Error -> status, and the kind where the page can do something about it."""


def create_app(
    project_folder: Path | str,
    launch: Launch = start_run,
    *,
    token: str | None = None,
    source: JournalRuns | None = None,
    task: str | None = None,
    autostart: RunOptions | None = None,
    show_run: str | None = None,
    study: Path | None = None,
) -> FastAPI:
    """Return the server of one project.

    Args:
        project_folder: the folder that it serves; nothing outside it is reached.
        launch: starts the processes of runs; `grip run` by default.
        token: who has it may talk to the server; a fresh one by default, found as `app.state.token`.
        source: where runs are read; the project's journal by default.
        task: the task that the page opens first, relative to the folder.
        autostart: run `task` with these options as soon as the server is up.
        show_run: the run that the page shows first.
        study: CSV file for how long each part of the page has the focus; None to measure nothing.

    Raises:
        GripError: that run, the folder or the task isn't there, or the page wasn't built.
    """
    if not (STATIC / "index.html").is_file():
        raise MissingPartError("the editor's page", "npm ci && npm run build in gui/frontend")
    folder = ProjectFolder(project_folder)
    task_file = folder.task_file(task) if task is not None else None
    runs = source or JournalRuns(folder.journal, folder.folder)
    control = RunControl(launch, folder.journal, runs)

    if show_run is not None:
        control.show(show_run)

    @asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncIterator[None]:
        if autostart is not None and task is not None and task_file is not None:
            await control.start(task, task_file, autostart)
        yield
        await asyncio.gather(control.close(), window.close())

    app = FastAPI(title="GRIP editor", lifespan=lifespan, docs_url=None, redoc_url=None, openapi_url=None)
    app.state.token = token or token_urlsafe(24)
    app.add_middleware(Gate, token=app.state.token)
    for refused in (GripError, RequestValidationError, HTTPException):
        app.add_exception_handler(refused, _refuse)
    edits, window = DocumentStore(folder, control.follow_edit), RosClientProcess(folder.folder)
    runner = CommandRunner(folder.folder)
    app.include_router(make_edit_router(edits, control.notify))
    app.include_router(make_setup_router(folder, runner, runs, control.notify))
    app.include_router(make_live_router(folder, runner, window, lambda: control.run_under_way))
    app.include_router(make_router(folder, control, runs, task, edits))

    @app.post("/api/study")
    def spent(span: StudySpan) -> bool:
        """Add a span to the study's file; tell whether there is one."""
        if study is not None and span.seconds > 0:
            row = f"{time.time():.1f},{span.page},{span.window},{span.seconds:.1f}\n"
            with study.open("a") as out:
                out.write(row)
        return study is not None

    app.mount("/", StaticFiles(directory=STATIC, html=True))
    return app


async def _refuse(request: Request, error: Exception) -> JSONResponse:
    """Tell why a request isn't answered, also of what the framework itself refuses, such as a body that isn't text."""
    kind, headers = "", None
    if isinstance(error, RequestValidationError):
        faults = (f"{'.'.join(str(part) for part in e['loc'])}: {e['msg']}" for e in error.errors()[:5])
        status, why = 422, f"malformed request: {'; '.join(faults)}"
    elif isinstance(error, HTTPException):
        status, why, headers = error.status_code, error.detail, error.headers
    else:
        status, kind = next((found for cause, found in _REFUSALS.items() if isinstance(error, cause)), (400, ""))
        why = str(error)
    if request.url.path.startswith("/api/"):
        log.warning("%s %s refused: %s", request.method, request.url.path, why)
    return JSONResponse(ErrorBody(detail=why, kind=kind).model_dump(), status_code=status, headers=headers)


LARGEST_FRAME = 64 * 1024
"""Longest message on the socket that is taken in at all [bytes]; what the page sends is far shorter."""


def serve(
    project: Path | str,
    task: Path | str | None = None,
    autostart: RunOptions | None = None,
    port: int = 0,
    open_browser: bool = True,
    show_run: str | None = None,
    journal: Path | None = None,
    study: Path | None = None,
) -> int:
    """Serve a project's editor until Ctrl-C; afterwards no process of it is left. Return the exit status.

    Args:
        project: a project folder, or anything in it.
        task: the task file to open first; for `autostart`, `show_run` and `study` see `create_app`.
        port: 0 takes the one from before, where that is free, else any.
        open_browser: open the page when there is a display. The address is printed in any case.
        journal: where runs are read; None for the project's own.

    Raises:
        GripError: the project or the task isn't usable, or the port is taken.
    """
    folder = find_project(project).folder
    name = ProjectFolder(folder).relative(Path(task)) if task is not None else None
    source = JournalRuns(journal, folder) if journal is not None else None
    listener, token = listen(ProjectFolder(folder).journal.with_name("editor.json"), port)
    with listener:
        app = create_app(
            folder, token=token, task=name, autostart=autostart, source=source, show_run=show_run, study=study
        )
        url = f"http://{HOST}:{listener.getsockname()[1]}/?" + urlencode({"token": token})
        print(f"GRIP editor of {folder}\n  {url}\nCtrl-C ends it.", flush=True)  # noqa: T201 - this is for the person
        if open_browser and (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            threading.Thread(target=webbrowser.open, args=(url,), daemon=True).start()
        config = uvicorn.Config(
            app,
            log_level="warning",
            access_log=False,
            ws="websockets-sansio",
            ws_max_size=LARGEST_FRAME,
            server_header=False,
            timeout_graceful_shutdown=3,
        )
        with suppress(KeyboardInterrupt):  # uvicorn has shut down in order and raises the signal again for its caller
            asyncio.run(uvicorn.Server(config).serve(sockets=[listener]))
    return 0
