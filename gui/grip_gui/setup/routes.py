"""Questions and requests about the files that put a project together."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import PurePosixPath

from fastapi import APIRouter

from grip_bt.base.errors import GripError
from grip_gui.editing.files import TextFile
from grip_gui.processes import CommandRunner
from grip_gui.project import ProjectFolder
from grip_gui.runs.journal import JournalRuns
from grip_gui.setup.interfaces import look_at, make
from grip_gui.setup.kinds import kind_of
from grip_gui.setup.options import names_of
from grip_gui.setup.settings_store import SettingsStore, keep_value
from grip_gui.wire import setup as wire

_LEGACY = "legacy"  # where a file that is imported is kept, so that an import can be done again
_SUFFIXES = {"smach": ".py", "btcpp": ".xml", "pytrees": ".xml"}


def make_setup_router(
    folder: ProjectFolder, runner: CommandRunner, source: JournalRuns, changed: Callable[[], None]
) -> APIRouter:
    """Return the routes below `/api/setup`; `changed` is called in the loop when the project's nodes may be others."""
    api = APIRouter(prefix="/api/setup")
    desk = SettingsStore(folder)

    api.get("/files")(desk.files)
    api.get("/file")(desk.open)
    api.post("/check")(desk.check)
    api.post("/change")(desk.change)

    @api.get("/names")
    def names() -> dict[str, list[str]]:
        return names_of(folder.folder)

    @api.post("/save")
    async def save(request: wire.SetupSave) -> wire.SetupView:
        view = await asyncio.to_thread(desk.save, request)
        changed()
        return view

    @api.post("/probe")
    async def probe(request: wire.CommandRequest) -> wire.CommandResult:
        home = folder.settings_file(request.path).parent
        needed = "project" if request.what == "robot" else "component"
        if kind_of(request.path).name != needed:
            raise GripError(f"{request.path}: {request.what!r} is tried with a file of the kind {needed!r}")
        words = {"robot": ("robot", "check", "."), "generate": ("component", "add", str(home))}
        view = await runner.run(words.get(request.what, ("component", "test", str(home))))
        changed()
        return view

    @api.post("/interface")
    async def interface(request: wire.InterfaceRequest) -> wire.InterfaceView:
        if not request.create:
            return await asyncio.to_thread(look_at, folder, request)
        view, home = await asyncio.to_thread(make, folder, request)
        generated = await runner.run(("component", "add", str(home)))
        changed()
        if not generated.ok:
            raise GripError(f"{view.path} was written, but its node can't be generated:\n{generated.output}")
        return view.model_copy(update={"output": generated.output})

    @api.post("/import")
    async def bring(request: wire.ImportRequest) -> wire.ImportView:
        words = _kept_words(folder, request)
        before = _stamps(folder)
        view = await runner.run(words)
        changed()
        return wire.ImportView(
            probe=view, tasks=sorted(path for path, at in _stamps(folder).items() if at != before.get(path))
        )

    @api.post("/record")
    async def keep(request: wire.RecordRequest) -> wire.SetupView:
        path = await asyncio.to_thread(lambda: keep_value(folder, request.name, source.raw(request.run, request.seq)))
        return await asyncio.to_thread(desk.open, path)

    return api


def _kept_words(folder: ProjectFolder, request: wire.ImportRequest) -> tuple[str, ...]:
    """Keep a file that is imported, which is read and never executed; return the words of the import."""
    suffix, given = _SUFFIXES[request.source], PurePosixPath(request.name)
    if given.suffix != suffix or given.name != request.name:
        raise GripError(
            f"{request.name!r}: a file of {request.source} ends with {suffix} and has no folder in its name"
        )
    kept = TextFile(folder.folder / _LEGACY / request.name, f"{_LEGACY}/{request.name}")
    if not kept.path.resolve().is_relative_to(folder.folder):
        raise GripError(f"{kept.name}: leads out of the project folder")
    if kept.path.exists() and kept.read() != request.text:
        raise GripError(f"{kept.name} is there with another text; give the file another name")
    kept.write(request.text)
    out = "tasks" if request.source == "smach" else f"tasks/{given.stem}.yaml"
    return ("import", kept.name, "--from", request.source, "-o", out)


def _stamps(folder: ProjectFolder) -> dict[str, int]:
    return {entry.path: (folder.folder / entry.path).stat().st_mtime_ns for entry in folder.tasks()}
