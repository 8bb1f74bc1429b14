"""Questions and wishes about what runs beside the editor.

What can't be done is told in the answer, not as an error: that nobody publishes, or that there is no ROS, is ordinary.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from functools import partial
from typing import Annotated, Any

from fastapi import APIRouter, Query
from pydantic import ValidationError

from grip_bt.app.project.folder import find_project
from grip_bt.base.errors import GripError
from grip_bt.base.yaml.tree import parse, to_data
from grip_gui.editing.files import TextFile
from grip_gui.live import RosWindow
from grip_gui.live.motion import last_state, motion_of
from grip_gui.live.samples import form_of, source_of
from grip_gui.live_messages import (
    ComponentForm,
    Done,
    GeometryView,
    LiveMessage,
    LiveMessages,
    MeasureWish,
    MessageDeed,
    MotionView,
    PutWish,
    ReceivedView,
    ReceiveWish,
    RobotParts,
    TopicsView,
    TryView,
    TryWish,
)
from grip_gui.project import ProjectFolder
from grip_gui.setup.changes import set_value
from grip_gui.setup.geometry import geometry
from grip_gui.setup.kinds import JOINT_STATES, POSES, kind_of
from grip_gui.setup.probes import Prober

RunId = Annotated[str, Query(pattern=r"^[A-Za-z0-9_-]+$", max_length=200)]


def make_live_router(folder: ProjectFolder, window: RosWindow, run: Callable[[], str]) -> APIRouter:
    """Return the routes below `/api/live`.

    Args:
        folder: the project.
        window: looks at ROS.
        run: returns the run under way, empty for none.
    """
    api = APIRouter(prefix="/api/live")
    _add_graph(api, window)
    _add_tries(api, folder, window, run)
    _add_calls(api, folder)
    _add_space(api, folder)
    return api


async def _asked(window: RosWindow, do: str, **fields: Any) -> dict[str, Any]:
    try:
        return await window.ask(do, **fields)
    except GripError as error:
        return {"trouble": str(error)}


def _add_graph(api: APIRouter, window: RosWindow) -> None:
    """Add what is asked of the running graph."""
    asked = partial(_asked, window)

    @api.get("/topics")
    async def topics() -> TopicsView:
        return TopicsView(**{"topics": [], "domain": "", **await asked("topics")})

    @api.post("/receive")
    async def receive(wish: ReceiveWish) -> ReceivedView:
        return ReceivedView(**await asked("receive", **wish.model_dump()))

    @api.get("/messages")
    async def messages() -> LiveMessages:
        return LiveMessages(**{"served": False, **await asked("messages")})

    @api.get("/message")
    async def message(store: str, name: str) -> LiveMessage:
        return LiveMessage(**await asked("message", store=store, name=name))

    @api.post("/put")
    async def put(wish: PutWish) -> Done:
        return Done(**await asked("put", **wish.model_dump()))

    @api.post("/messages")
    async def deed(wish: MessageDeed) -> Done:
        words = {"delete": {"store": wish.store, "name": wish.name}, "reset": {"store": wish.store}}.get(wish.do, {})
        found = await asked(wish.do, **words)
        if not found.get("trouble") and wish.do in ("serve", "end"):
            window.keep(wish.do == "serve")
        kept = f"{found['count']} kept for later runs of the server" if "count" in found else ""
        return Done(trouble=found.get("trouble", ""), said=kept)


def _add_tries(api: APIRouter, folder: ProjectFolder, window: RosWindow, run: Callable[[], str]) -> None:
    """Add what is tried with the project's own parts."""
    prober, asked = Prober(folder), partial(_asked, window)

    @api.get("/robot")
    def robot() -> RobotParts:
        try:
            file = find_project(folder.folder).file
        except GripError as error:
            return RobotParts(robot="", arms=[], hands=[], trouble=str(error))
        name = file.robot if isinstance(file.robot, str) else "described in grip.yaml" if file.robot else ""
        return RobotParts(robot=name, arms=list(file.arms), hands=list(file.hands), run=run())

    @api.post("/measure")
    async def measure(wish: MeasureWish) -> Done:
        joints = last_state(folder.journal, run(), wish.part) if wish.robot == "run" and run() else None
        if wish.robot == "run" and not joints:
            return Done(trouble=f"no run is under way that has measured {wish.part}")
        asked_for = json.dumps({"robot": wish.robot, "part": wish.part, "what": wish.what, "joints": joints})
        found = await prober.answer("grip_gui.live.measuring", (asked_for,))
        if "text" not in found:
            return Done(trouble=found["trouble"])
        return await keep(wish, found["text"])

    async def keep(wish: MeasureWish, text: str) -> Done:
        path, store = (POSES, "poses") if wish.what == "pose" else (JOINT_STATES, "joint_states")
        await asyncio.to_thread(_write, folder, path, wish.name, text)
        said = f"{wish.name} was written into {path}"
        if wish.serve:
            given = await asked("put", store=store, name=wish.name, type="", text=text)
            if given.get("trouble"):
                return Done(said=said, trouble=given["trouble"])
            said += ", and the server has it"
        return Done(said=said)


def _add_calls(api: APIRouter, folder: ProjectFolder) -> None:
    """Add what is asked of components."""
    prober = Prober(folder)

    @api.get("/component")
    def component(path: str) -> ComponentForm:
        kind_of(path)
        return form_of(folder.folder, folder.settings_file(path).parent)

    @api.post("/component")
    async def call(wish: TryWish) -> TryView:
        kind_of(wish.path)
        given = {
            each.port: source_of(each.sample) if each.sample else {"text": each.text}
            for each in wish.given
            if each.sample or each.text.strip()
        }
        home = folder.settings_file(wish.path).parent
        try:
            asked_for = json.dumps({"folder": str(home), "given": given})
            return TryView(**await prober.answer("grip_gui.live.calling", (), asked_for))
        except (GripError, ValidationError) as error:
            return TryView(trouble=str(error))


def _add_space(api: APIRouter, folder: ProjectFolder) -> None:
    """Add what is drawn of the robot."""

    @api.get("/geometry")
    def looks() -> GeometryView:
        try:
            file = find_project(folder.folder).file
        except GripError as error:
            return GeometryView(trouble=str(error))
        robot = file.robot if file.robot is None or isinstance(file.robot, str) else file.robot.model_dump(mode="json")
        hands = {arm.hand: arm.group for arm in file.arms.values() if arm.hand is not None}
        return GeometryView.model_validate(geometry(robot, hands, folder.folder))

    @api.get("/motion")
    def motion(run: RunId, after: Annotated[int, Query(ge=0, le=2**40)] = 0) -> MotionView:
        return motion_of(folder.journal, run, after)


def _write(folder: ProjectFolder, path: str, name: str, text: str) -> None:
    file = TextFile(folder.settings_file(path), path)
    before = file.read() if file.path.exists() else kind_of(path).blank
    file.write(set_value(before, [name], to_data(parse(text))))
