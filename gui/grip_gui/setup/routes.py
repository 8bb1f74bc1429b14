"""Questions and requests about the files that put a project together.

An interface that was pasted or named is on its way to a component: its fields, what is wrong, and its folder.
"""

from __future__ import annotations

import asyncio
import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from importlib.resources import files
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import Annotated

from fastapi import APIRouter, Query
from fastapi.responses import FileResponse
from pydantic import ValidationError

from grip_bt.app.project.components import Draft, components_folder, from_file, make_component, served_in
from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import ContractError, DocumentError, GripError
from grip_bt.base.yaml.models import check_model, diagnostic_of
from grip_bt.base.yaml.tree import YamlMapping, parse
from grip_bt.codegen.contract import INPUT, OUTCOME, RETURNED, check_contract, suggested_outcomes
from grip_bt.codegen.scaffold import component_text, parse_outcomes, suggested_name
from grip_bt.ros.interfaces import read_interface
from grip_bt.task.catalog.component_file import ComponentFile
from grip_bt.task.catalog.ros_config import InterfaceSpec
from grip_gui.editing.files import TextFile
from grip_gui.processes import CommandRunner
from grip_gui.project import ProjectFolder
from grip_gui.runs.journal import JournalRuns
from grip_gui.setup import beginning
from grip_gui.setup.kinds import kind_of
from grip_gui.setup.options import names_of
from grip_gui.setup.settings_store import SettingsStore, keep_value, set_value
from grip_gui.wire import setup as wire
from grip_gui.wire.setup import FieldView, InterfaceRequest, InterfaceView

_LEGACY = "legacy"  # where a file that is imported is kept, so that an import can be done again
_SUFFIXES = {"smach": ".py", "btcpp": ".xml", "pytrees": ".xml"}


def make_setup_router(
    folder: ProjectFolder, runner: CommandRunner, source: JournalRuns, changed: Callable[[], None]
) -> APIRouter:
    """Return the routes below `/api/setup`; `changed` is called in the loop when the project's nodes may be others."""
    api = APIRouter(prefix="/api/setup")
    settings = SettingsStore(folder)

    api.get("/files")(settings.files)
    api.get("/file")(settings.open)
    api.post("/check")(settings.check)
    api.post("/change")(settings.change)
    api.get("/names")(partial(names_of, folder.folder))

    @api.post("/save")
    async def save(request: wire.SetupSave) -> wire.SetupView:
        view = await asyncio.to_thread(settings.save, request)
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
        words = _words_of(folder, request)
        before = _stamps(folder)
        view = await runner.run(words)
        changed()
        tasks = sorted(path for path, at in _stamps(folder).items() if at != before.get(path))
        return wire.ImportView(probe=view, tasks=tasks)

    _add_beginning(api, folder, runner, changed)

    @api.get("/picture")
    async def picture(world: Annotated[str, Query(pattern=r"^[A-Za-z0-9_]+$")], camera: str = "") -> FileResponse:
        file = find_project(folder.folder).state_folder / f"{world}.png"
        said = await runner.run(("world", "show", world, "--picture", str(file), f"--camera={camera}"))
        if not said.ok:
            raise GripError(said.output.strip())
        return FileResponse(file, headers={"cache-control": "no-store"})

    @api.post("/record")
    async def keep(request: wire.RecordRequest) -> wire.SetupView:
        path = await asyncio.to_thread(lambda: keep_value(folder, request.name, source.raw(request.run, request.seq)))
        return await asyncio.to_thread(settings.open, path)

    return api


def _add_beginning(api: APIRouter, folder: ProjectFolder, runner: CommandRunner, changed: Callable[[], None]) -> None:
    api.get("/robots")(beginning.robots)
    api.get("/pairs")(beginning.pairs)
    api.get("/examples")(beginning.examples)

    @api.get("/browse")
    def browse(at: str = "") -> wire.FolderView:
        return beginning.browse(at, folder.folder)

    @api.post("/begin")
    async def begin(request: wire.BeginRequest) -> wire.BeginView:
        beginning.check_request(request, folder.folder)
        found = await runner.answer("grip_gui.setup.beginning", folder=str(folder.folder), **request.model_dump())
        changed()
        return wire.BeginView(**found)


def _words_of(folder: ProjectFolder, request: wire.ImportRequest) -> tuple[str, ...]:
    """Return the words of an import; a file that was sent is kept first."""
    path = request.path or _kept(folder, request)
    given = folder.folder / path
    if "\0" in path or request.path and not Path(path).is_absolute() or not given.exists():
        raise DocumentError("isn't there", path)
    several = request.source == "smach" or given.is_dir()
    out = "." if request.source == "grip" else "tasks" if several else f"tasks/{given.stem}.yaml"
    return ("import", path, "--from", request.source, "-o", out, *(("--execute",) if request.execute else ()))


def _kept(folder: ProjectFolder, request: wire.ImportRequest) -> str:
    """Keep a file that is imported; return its path in the project."""
    if request.source not in _SUFFIXES:
        raise GripError("a task of the first GRIP is several files: choose its folder")
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
    return kept.name


def _stamps(folder: ProjectFolder) -> dict[str, int]:
    return {entry.path: (folder.folder / entry.path).stat().st_mtime_ns for entry in folder.tasks()}


_TYPE = re.compile(r"^(?P<package>[a-z][a-z0-9_]*)/(?P<kind>srv|action|msg)/(?P<name>[A-Z][A-Za-z0-9]*)$")
_OTHER = re.compile(r"^\s*([a-z][a-z0-9_]*)/[A-Z]", re.MULTILINE)  # a field of another package's type
_NOTHING = YamlMapping({}, 1, 1)
_PACKAGE = files("grip_bt.codegen") / "repository/python/interfaces/component_name_interfaces/package.xml"


def look_at(folder: ProjectFolder, request: InterfaceRequest) -> InterfaceView:
    """Return what an interface has, and what keeps it from being a component; nothing is written.

    The project's own interface packages are known besides the installed ones.
    """
    with _found(folder, request) as found:
        return _view(folder, request, found)


def make(folder: ProjectFolder, request: InterfaceRequest) -> tuple[InterfaceView, Path]:
    """Write the component's folder; return what was written, and where.

    Raises:
        ContractError: something keeps it from being a component.
    """
    with _found(folder, request) as found:
        view = _view(folder, request, found)
        if view.problems:
            raise ContractError(found.interface.type_name, view.problems)
        named = replace(found, server=request.server or found.server, name=request.name)
        outcomes = request.outcomes or view.suggestion
        # Of what is suggested, these don't mean success.
        failures = request.failures or [w for w in ("failed", "none") if not request.outcomes and w in outcomes]
        home = make_component(named, components_folder(folder.folder), outcomes, failures)
        if found.script is not None:
            file = home / "component.yaml"
            command = ["{python}", os.path.relpath(found.script, home)]
            file.write_text(set_value(file.read_text("utf-8"), ["start"], {"command": command}), "utf-8")
    return view.model_copy(update={"path": folder.relative(home / "component.yaml")}), home


def _view(folder: ProjectFolder, request: InterfaceRequest, found: Draft) -> InterfaceView:
    interface = found.interface
    suggestion = suggested_outcomes(interface)
    sides = {"action": ("goal", "result"), "msg": ("message", "")}.get(interface.kind, ("request", "response"))
    fields = [
        FieldView(side=side, name=field.name, type=field.spelling)
        for side, part in zip(sides, (interface.request, interface.response), strict=True)
        for field in part
    ]
    text, problems = "", []
    name = request.name or suggested_name(interface)
    try:
        # Who has one of the contract's fields means the contract, and wants to know what it lacks.
        meant = any(f.name in (INPUT, OUTCOME, RETURNED) for f in (*interface.request, *interface.response))
        outcomes = parse_outcomes(request.outcomes or ("done,failed" if meant else suggestion))
        text = component_text(interface, name, request.server or found.server or f"/{name}", outcomes, request.failures)
        component, faults = check_model(parse(text), ComponentFile)
        problems = [message for message, _, _ in faults]
        if component is not None:
            check_contract(component, interface)
    except ContractError as error:
        problems = list(error.problems)
    except ValidationError as error:
        problems = [diagnostic_of(_NOTHING, e)[0] for e in error.errors()]
    except GripError as error:
        problems = [str(error).removeprefix("--")]  # the command line's option is this page's field
    problems = [*_unknown_types(folder, interface), *problems]
    script = found.script.name if found.script else ""
    told = {"type": interface.type_name, "server": found.server, "script": script}
    return InterfaceView(fields=fields, problems=problems, suggestion=suggestion, text=text, path="", output="", **told)


def _unknown_types(folder: ProjectFolder, interface: InterfaceSpec) -> Iterator[str]:
    """Yield the fields whose message is nowhere: neither installed, nor in the project's own packages."""
    own = Path(interface.source).parent.parent
    for field in (*interface.request, *interface.response, *interface.feedback):
        package, _, name = field.type.partition("/msg/")
        if not name:
            continue
        homes = (
            [own] if package == interface.package else components_folder(folder.folder).glob(f"*/interfaces/{package}")
        )
        if any((home / "msg" / f"{name}.msg").is_file() for home in homes):
            continue
        try:
            read_interface(field.type)
        except DocumentError as error:
            yield f"the field {field.name!r} is of type {field.spelling}: {error.message}"


@contextmanager
def _found(folder: ProjectFolder, request: InterfaceRequest) -> Iterator[Draft]:
    """Give the interface: of a repository's file, an installed type, or a package made of what was pasted."""
    if request.file:
        if "\0" in request.file or not Path(request.file).is_absolute():
            raise GripError(f"{request.file!r} isn't a path on this machine")
        yield served_in(from_file(Path(request.file)))
        return
    name = _TYPE.match(request.type.strip())
    if name is None:
        raise GripError(f"{request.type!r} isn't the name of an interface, such as my_interfaces/srv/PlanGrasp")
    if not request.text.strip():
        own = f"*/interfaces/{name['package']}/{name['kind']}/{name['name']}.{name['kind']}"
        file = next(components_folder(folder.folder).glob(own), None)
        yield Draft(read_interface(request.type.strip())) if file is None else from_file(file)
        return
    with TemporaryDirectory() as place:
        package = Path(place) / name["package"]
        file = package / name["kind"] / f"{name['name']}.{name['kind']}"
        file.parent.mkdir(parents=True)
        file.write_text(request.text, encoding="utf-8")
        needed = sorted(set(_OTHER.findall(request.text)) - {name["package"]})
        depends = "".join(f"  <depend>{other}</depend>\n" for other in needed)
        described = re.sub(r"( *<depend>.*\n)+", depends, _PACKAGE.read_text(encoding="utf-8"))
        described = described.replace("component_name_interfaces", name["package"])
        (package / "package.xml").write_text(described, encoding="utf-8")
        try:
            yield from_file(file)
        except DocumentError as error:
            raise DocumentError(error.message, file.name, error.line, error.column) from None
