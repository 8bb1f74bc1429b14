"""Questions and requests about what runs beside the editor, and what was recorded of runs.

What can't be done is told in the answer, not as an error: that nobody publishes, or that there is no ROS, is ordinary.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter, Query
from pydantic import ValidationError

from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.app.project.folder import find_project
from grip_bt.app.runs.motion_record import motion_file
from grip_bt.base.errors import GripError
from grip_bt.base.message_store import STANDARD, MessageLibrary
from grip_bt.commanders.description.packages import ROBOTS
from grip_bt.runtime import JournalReader
from grip_gui.live.ros_client import RosClientProcess
from grip_gui.processes import CommandRunner
from grip_gui.project import ProjectFolder
from grip_gui.setup.kinds import JOINT_STATES, POSES, kind_of
from grip_gui.setup.robot_drawing import geometry
from grip_gui.setup.settings_store import keep_text
from grip_gui.wire import live as wire
from grip_gui.wire.live import ComponentForm, MotionSample, MotionView, RequestPort, Sample

RunId = Annotated[str, Query(pattern=r"^[A-Za-z0-9_-]+$", max_length=200)]


def make_live_router(
    folder: ProjectFolder, runner: CommandRunner, window: RosClientProcess, run: Callable[[], str]
) -> APIRouter:
    """Return the routes below `/api/live`; `run` returns the run under way, empty for none."""
    api = APIRouter(prefix="/api/live")
    _add_graph(api, window)
    _add_project(api, folder)
    _add_tries(api, folder, runner, window, run)
    return api


async def _asked(window: RosClientProcess, do: str, **fields: object) -> dict[str, Any]:
    try:
        return await window.ask(do, **fields)
    except GripError as error:
        return {"error": str(error)}


def _add_graph(api: APIRouter, window: RosClientProcess) -> None:
    """Add what is asked of the running graph."""
    asked = partial(_asked, window)

    @api.get("/topics")
    async def topics() -> wire.TopicsView:
        return wire.TopicsView(**await asked("topics"))

    @api.post("/receive")
    async def receive(request: wire.ReceiveRequest) -> wire.ReceivedView:
        return wire.ReceivedView(**await asked("receive", **request.model_dump()))

    @api.get("/messages")
    async def messages() -> wire.LiveMessages:
        return wire.LiveMessages(**await asked("messages"))

    @api.get("/message")
    async def message(store: str, name: str) -> wire.LiveMessage:
        return wire.LiveMessage(**await asked("message", store=store, name=name))

    @api.post("/put")
    async def put(request: wire.PutRequest) -> wire.Done:
        return wire.Done(**await asked("put", **request.model_dump()))

    @api.post("/messages")
    async def deed(request: wire.MessageRequest) -> wire.Done:
        words = {"delete": {"store", "name"}, "reset": {"store"}}
        found = await asked(request.do, **request.model_dump(include=words.get(request.do, set())))
        kept = f"{found['count']} kept for later runs of the server" if "count" in found else ""
        return wire.Done(error=found.get("error", ""), said=kept)


def _add_project(api: APIRouter, folder: ProjectFolder) -> None:
    """Add what the project's files and the records of its runs say."""

    @api.get("/geometry")
    def looks(robot: Annotated[str, Query(max_length=1024)] = "") -> wire.GeometryView:
        if robot in ROBOTS or Path(robot).is_absolute() and "\0" not in robot:
            return wire.GeometryView.model_validate(geometry(robot, {}, folder.folder))
        try:
            file = find_project(folder.folder).file
        except GripError as error:
            return wire.GeometryView(error=str(error))
        own = file.robot if file.robot is None or isinstance(file.robot, str) else file.robot.model_dump(mode="json")
        hands = {arm.hand: arm.group for arm in file.arms.values() if arm.hand is not None}
        return wire.GeometryView.model_validate(geometry(own, hands, folder.folder))

    @api.get("/motion")
    def motion(run: RunId, after: Annotated[int, Query(ge=0, le=2**40)] = 0) -> wire.MotionView:
        return motion_of(folder.journal, run, after)

    @api.get("/component")
    def component(path: str) -> wire.ComponentForm:
        kind_of(path)
        return form_of(folder.folder, folder.settings_file(path).parent)


def _add_tries(
    api: APIRouter, folder: ProjectFolder, runner: CommandRunner, window: RosClientProcess, run: Callable[[], str]
) -> None:
    """Add what is tried with the project's own parts."""

    @api.post("/component")
    async def call(request: wire.TryRequest) -> wire.TryView:
        kind_of(request.path)
        given = {
            each.port: source_of(each.sample) if each.sample else {"text": each.text}
            for each in request.given
            if each.sample or each.text.strip()
        }
        home = folder.settings_file(request.path).parent
        try:
            return wire.TryView(**await runner.answer("grip_gui.live.trying", folder=str(home), given=given))
        except (GripError, ValidationError) as error:
            return wire.TryView(error=str(error))

    @api.post("/measure")
    async def measure(request: wire.MeasureRequest) -> wire.Done:
        joints = last_state(folder.journal, run(), request.part) if request.robot == "run" and run() else None
        if request.robot == "run" and not joints:
            return wire.Done(error=f"no current run has measured {request.part}")
        question = request.model_dump(include={"robot", "part", "what"})
        try:
            text = (await runner.answer("grip_gui.live.trying", **question, joints=joints))["text"]
        except GripError as error:
            return wire.Done(error=str(error))
        path, store = (POSES, "poses") if request.what == "pose" else (JOINT_STATES, "joint_states")
        await asyncio.to_thread(keep_text, folder, path, request.name, text)
        said, why = f"{request.name} was written into {path}", ""
        if request.serve:
            given = await _asked(window, "put", store=store, name=request.name, type="", text=text)
            why = given.get("error", "")
            said += "" if why else ", and the server has it"
        return wire.Done(said=said, error=why)


MOST = 1 << 20  # most that is read at once [bytes]


def motion_of(journal: Path, run: str, after: int) -> MotionView:
    """Return the next piece of the record of a journal's run, after where the last one ended; empty where none is."""
    file = motion_file(journal, run)
    if not file.is_file():
        return MotionView(samples=[], next=0)
    with file.open("rb") as record:
        record.seek(after)
        piece = record.read(MOST)
    whole = piece[: piece.rfind(b"\n") + 1]  # the last line may be being written
    parts: dict[str, list[str]] = {}
    bodies: dict[str, Any] = {}
    samples = []
    for line in whole.splitlines():
        data: dict[str, Any] = json.loads(line)
        if "parts" in data:
            parts = data["parts"]
        else:
            bodies |= data.pop("bodies", {})
            samples.append(MotionSample(**data))
    return MotionView(parts=parts, bodies=bodies, samples=samples, next=after + len(whole))


def last_state(journal: Path, run: str, part: str) -> dict[str, float]:
    """Return where a part was measured last: joint -> position [rad or m]; empty where it never was."""
    joints, positions, after = list[str](), list[float](), 0
    while (piece := motion_of(journal, run, after)).next > after:
        after, joints = piece.next, piece.parts.get(part, joints)
        positions = next((s.q[part] for s in reversed(piece.samples) if part in s.q), positions)
    return dict(zip(joints, positions, strict=False))


RUNS, EACH = 10, 12
"""Runs that are looked through, the latest ones, and samples of a port."""


def form_of(folder: Path, home: Path) -> ComponentForm:
    """Return the inputs of the component in a project's folder `home`, and what was recorded for them."""
    try:
        project = find_project(folder)
        name = next((name for name, place in project.component_folders().items() if place == home), home.name)
        manifest = catalogue_of(project).get(f"component/{name}")
    except GripError as error:
        return ComponentForm(name=home.name, error=f"Generate its node first. {error}")
    recorded = list(_written(project.journal))
    inputs = [
        RequestPort(name=port, type=face.type, doc=face.doc, samples=_fitting(face.type, recorded, folder))
        for port, face in manifest.inputs.items()
    ]
    return ComponentForm(name=name, inputs=inputs)


def source_of(sample: str) -> dict[str, Any]:
    """Return where a sample is: `{run, seq}` or `{store, name}`."""
    kind, _, rest = sample.partition(":")
    first, _, second = rest.partition("/")
    if kind == "run" and second.isdigit():
        return {"run": first, "seq": int(second)}
    if kind == "messages" and second:
        return {"store": first, "name": second}
    raise GripError(f"{sample!r} isn't a sample; there are run:RUN/SEQ and messages:STORE/NAME")


def _written(journal: Path) -> Iterable[tuple[str, Sample]]:
    if not journal.is_file():
        return
    try:
        with JournalReader(journal) as reader:
            for run in reader.runs()[:RUNS]:
                for variable, event in reader.variables(run.id).items():
                    type_name = str(event.data.get("type", ""))
                    title = f"{variable} of {run.task_name}, run {run.id[-6:]}"
                    yield type_name, Sample(source=f"run:{run.id}/{event.seq}", title=title, type=type_name)
    except GripError:
        return  # a journal that can't be read has no samples; runs tell why


def _fitting(type_name: str, recorded: Iterable[tuple[str, Sample]], folder: Path) -> list[Sample]:
    found = [sample for written, sample in recorded if written == type_name][:EACH]
    store = next((name for name, held in STANDARD.items() if held == type_name), None)
    if store is not None and (folder / "messages").is_dir():
        try:
            names = MessageLibrary(folder / "messages").store(store).names()
        except GripError:
            names = ()
        found += [
            Sample(source=f"messages:{store}/{name}", title=f"{name} of {store}", type=type_name) for name in names
        ]
    return found
