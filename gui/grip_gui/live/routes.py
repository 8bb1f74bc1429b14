"""Questions and requests about what runs beside the editor.

What can't be done is told in the answer, not as an error: that nobody publishes, or that there is no ROS, is ordinary.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from typing import Annotated, Any

from fastapi import APIRouter, Query
from pydantic import ValidationError

from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import GripError
from grip_gui.live.recorded import form_of, last_state, motion_of, source_of
from grip_gui.live.ros_client import RosClientProcess
from grip_gui.processes import CommandRunner
from grip_gui.project import ProjectFolder
from grip_gui.setup.kinds import JOINT_STATES, POSES, kind_of
from grip_gui.setup.robot_facts import geometry
from grip_gui.setup.settings_store import keep_text
from grip_gui.wire import live as wire

RunId = Annotated[str, Query(pattern=r"^[A-Za-z0-9_-]+$", max_length=200)]


def make_live_router(
    folder: ProjectFolder, runner: CommandRunner, window: RosClientProcess, run: Callable[[], str]
) -> APIRouter:
    """Return the routes below `/api/live`; `run` returns the run under way, empty for none."""
    api = APIRouter(prefix="/api/live")
    _add_graph(api, window)
    _add_project(api, folder, run)
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


def _add_project(api: APIRouter, folder: ProjectFolder, run: Callable[[], str]) -> None:
    """Add what the project's files and the records of its runs say."""

    @api.get("/robot")
    def robot() -> wire.RobotParts:
        try:
            file = find_project(folder.folder).file
        except GripError as error:
            return wire.RobotParts(error=str(error))
        return wire.RobotParts(arms=list(file.arms), hands=list(file.hands), run=run())

    @api.get("/geometry")
    def looks() -> wire.GeometryView:
        try:
            file = find_project(folder.folder).file
        except GripError as error:
            return wire.GeometryView(error=str(error))
        robot = file.robot if file.robot is None or isinstance(file.robot, str) else file.robot.model_dump(mode="json")
        hands = {arm.hand: arm.group for arm in file.arms.values() if arm.hand is not None}
        return wire.GeometryView.model_validate(geometry(robot, hands, folder.folder))

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
        found = await runner.answer("grip_gui.live.trying", **question, joints=joints)
        if "text" not in found:
            return wire.Done(error=found["error"])
        text = found["text"]
        path, store = (POSES, "poses") if request.what == "pose" else (JOINT_STATES, "joint_states")
        await asyncio.to_thread(keep_text, folder, path, request.name, text)
        said, why = f"{request.name} was written into {path}", ""
        if request.serve:
            given = await _asked(window, "put", store=store, name=request.name, type="", text=text)
            why = given.get("error", "")
            said += "" if why else ", and the server has it"
        return wire.Done(said=said, error=why)
