"""Questions and wishes about what runs beside the editor.

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
from grip_gui.live.motion import last_state, motion_of
from grip_gui.live.samples import form_of, source_of
from grip_gui.live.window import RosWindow
from grip_gui.processes import Prober
from grip_gui.project import ProjectFolder
from grip_gui.setup.geometry import geometry
from grip_gui.setup.kinds import JOINT_STATES, POSES, kind_of
from grip_gui.setup.named import keep_text
from grip_gui.wire.live import (
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

RunId = Annotated[str, Query(pattern=r"^[A-Za-z0-9_-]+$", max_length=200)]


def make_live_router(folder: ProjectFolder, prober: Prober, window: RosWindow, run: Callable[[], str]) -> APIRouter:
    """Return the routes below `/api/live`.

    Args:
        folder: the project.
        prober: tries one thing at a time.
        window: looks at ROS.
        run: returns the run under way, empty for none.
    """
    api = APIRouter(prefix="/api/live")
    _add_graph(api, window)
    _add_tries(api, folder, prober, window, run)
    _add_calls(api, folder, prober)
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


def _add_tries(
    api: APIRouter, folder: ProjectFolder, prober: Prober, window: RosWindow, run: Callable[[], str]
) -> None:
    """Add what is tried with the project's own parts."""
    asked = partial(_asked, window)

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
        question = {"robot": wish.robot, "part": wish.part, "what": wish.what, "joints": joints}
        found = await prober.answer("grip_gui.live.measuring", **question)
        if "text" not in found:
            return Done(trouble=found["trouble"])
        return await keep(wish, found["text"])

    async def keep(wish: MeasureWish, text: str) -> Done:
        path, store = (POSES, "poses") if wish.what == "pose" else (JOINT_STATES, "joint_states")
        await asyncio.to_thread(keep_text, folder, path, wish.name, text)
        said = f"{wish.name} was written into {path}"
        if wish.serve:
            given = await asked("put", store=store, name=wish.name, type="", text=text)
            if given.get("trouble"):
                return Done(said=said, trouble=given["trouble"])
            said += ", and the server has it"
        return Done(said=said)


def _add_calls(api: APIRouter, folder: ProjectFolder, prober: Prober) -> None:
    """Add what is asked of components."""

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
            return TryView(**await prober.answer("grip_gui.live.calling", folder=str(home), given=given))
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
