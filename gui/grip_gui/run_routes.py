"""Wishes about the run under way: start, control, breakpoints, and who holds control."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

from fastapi import APIRouter

from grip_bt.app.wiring.parts import RobotKind
from grip_bt.base.errors import GripError, UnknownNameError
from grip_gui.documents import task_view
from grip_gui.from_here import mocks_before
from grip_gui.launcher import RunOptions
from grip_gui.project import ProjectFolder
from grip_gui.run_desk import RunDesk
from grip_gui.run_messages import BreakpointsWish, Control, DeskView, LeaseWish, SessionView, StartRun


def robots() -> list[str]:
    """Return what a run may be started on."""
    return [str(kind) for kind in get_args(RobotKind)]


def make_run_router(folder: ProjectFolder, desk: RunDesk) -> APIRouter:
    """Return the routes below `/api` that start and control runs."""
    api = APIRouter(prefix="/api")

    @api.get("/session")
    async def session() -> SessionView | None:
        return desk.view

    @api.post("/session", status_code=201)
    async def start(wish: StartRun) -> SessionView:
        file = folder.task_file(wish.task)
        try:
            return await desk.start(wish.task, file, _options(folder, wish), wish.page, wish.run_to)
        except OSError as error:
            raise GripError(f"the run's process can't be started: {error}") from error

    @api.post("/session/control")
    async def control(wish: Control) -> SessionView:
        return await desk.command(wish)

    @api.get("/desk")
    async def shared() -> DeskView:
        return desk.desk_view

    @api.post("/breakpoints")
    async def breakpoints(wish: BreakpointsWish) -> DeskView:
        folder.task_file(wish.task)
        try:
            return await desk.set_breakpoints(wish.task, wish.breakpoints, wish.page)
        except OSError as error:
            raise GripError(f"the breakpoints can't be kept: {error}") from error

    @api.post("/lease")
    async def lease(wish: LeaseWish) -> DeskView:
        if wish.take:
            desk.lease.take(wish.page, wish.over)
        else:
            desk.lease.give(wish.page)
        return desk.desk_view

    return api


def _options(folder: ProjectFolder, wish: StartRun) -> RunOptions:
    if wish.robot not in robots():
        raise UnknownNameError("robot", wish.robot, robots(), "grip run --robot")
    options = RunOptions(robot=wish.robot, target=wish.target, seed=wish.seed, pace=wish.pace, mocks=wish.mocks)
    if not wish.begin_at:
        return options
    return replace(options, mocks={**mocks_before(task_view(folder, wish.task), wish.begin_at), **wish.mocks})
