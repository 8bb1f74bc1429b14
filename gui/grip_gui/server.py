"""Serves the editor on this machine until Ctrl-C."""

from __future__ import annotations

import asyncio
import os
import socket
import threading
import webbrowser
from pathlib import Path
from urllib.parse import urlencode

import uvicorn

from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import GripError
from grip_gui.application import create_app
from grip_gui.journal import JournalRuns
from grip_gui.launcher import RunOptions
from grip_gui.project import ProjectFolder

HOST = "127.0.0.1"
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
) -> int:
    """Serve a project's editor until Ctrl-C; afterwards no process of it is left.

    Args:
        project: a project folder, or anything in it.
        task: the task file to open first.
        autostart: start a run of `task` at once, with these options.
        port: 0 takes a free one.
        open_browser: open the page when there is a display. The address is printed in any case.
        show_run: the run that the page shows first.
        journal: where runs are read; None for the project's own.

    Returns:
        the exit status: 0.

    Raises:
        GripError: the project or the task isn't usable, or the port is taken.
    """
    folder = find_project(project).folder
    name = ProjectFolder(folder).relative(Path(task)) if task is not None else None
    source = JournalRuns(journal, folder) if journal is not None else None
    app = create_app(folder, task=name, autostart=autostart, source=source, show_run=show_run)
    with _listen(port) as listener:
        url = f"http://{HOST}:{listener.getsockname()[1]}/?" + urlencode({"token": app.state.token})
        print(f"GRIP editor of {folder}\n  {url}\nCtrl-C ends it.", flush=True)  # noqa: T201 - this is for the person
        if open_browser and has_display():
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
        try:
            asyncio.run(uvicorn.Server(config).serve(sockets=[listener]))
        except KeyboardInterrupt:
            pass  # uvicorn has shut down in order and raises the signal again for its caller
    return 0


def has_display() -> bool:
    """Tell whether a browser window could appear."""
    return any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))


def _listen(port: int) -> socket.socket:
    try:
        return socket.create_server((HOST, port))
    except OSError as error:
        raise GripError(
            f"port {port} of {HOST} isn't free ({error.strerror}); leave --port out for a free one"
        ) from error
