"""Who plans for a project's arms: the planning process, MoveIt's move_group, or each for some of them."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from typing import TYPE_CHECKING

from grip_bt.base.errors import MissingPartError
from grip_bt.base.operation import Operation
from grip_bt.task.catalog.ros_config import MOVE_GROUP, MoveGroupConfig

from ..project.config import ArmConfig
from ..project.folder import Project

if TYPE_CHECKING:
    from grip_bt.base.values import Plan
    from grip_bt.commanders.description.robot import RobotDescription
    from grip_bt.commanders.planning.requests import ChosenGrasp, Request
    from grip_bt.commanders.planning.service import PlanningService, Searcher
    from grip_bt.ros.client.bus import Bus


class PlannerByName:
    """Implements `planning.service.PlanningService`: a search goes to who its arm's settings name.

    Args:
        own: answers what nobody else is named for, every request about a motion that is given, and motions
            through way points (with the default planner): nobody else blends as ours does.
        others: planner's name -> who searches.
    """

    def __init__(self, own: PlanningService, others: Mapping[str, Searcher]):
        self._own, self._others = own, others

    def submit(self, request: Request) -> Operation[Plan | ChosenGrasp | None]:
        """Ask; see `PlanningService`."""
        from grip_bt.commanders.planning.requests import (
            ChooseGrasp,
            PlanningSettings,
            PlanStraight,
            PlanThrough,
            PlanTo,
        )

        situation = request.situation
        if isinstance(request, PlanThrough) and situation.settings.planner in self._others:
            usual = replace(situation.settings, planner=PlanningSettings().planner)
            request = replace(request, situation=replace(situation, settings=usual))
        if isinstance(request, PlanTo | PlanStraight | ChooseGrasp):
            return self._others.get(request.situation.settings.planner, self._own).submit(request)
        return self._own.submit(request)


def planners_in_force(project: Project, description: RobotDescription) -> str:
    """Return the names of the planners that the project's arms are planned for with, for people."""
    from .commanders import settings_of

    return ", ".join(sorted({settings_of(arm, description, 0).planner for arm in project.file.arms.values()}))


def wants_move_group(project: Project) -> bool:
    """Tell whether MoveIt plans for an arm of the project."""
    return any(arm.planner == MOVE_GROUP for arm in project.file.arms.values())


def with_move_group(
    project: Project, description: RobotDescription, own: PlanningService, stack: ExitStack, bus: Bus | None = None
) -> PlanningService:
    """Return a planner that has MoveIt answer for the arms that say so.

    Args:
        project: whose arms.
        description: the robot.
        own: who answers for the others.
        stack: closes what was opened.
        bus: the connection to ROS; one of its own, in the user's domain, when there is none.

    Raises:
        MissingPartError: ROS isn't installed, or MoveIt's messages aren't and can't be built.
        UnknownNameError: an arm names a hand or a group that isn't there.
    """
    if not wants_move_group(project):
        return own
    try:
        from grip_bt.ros.client.bus import Bus
        from grip_bt.ros.moveit import Mount, MoveGroup, MoveGroupPlanner
    except ImportError as error:
        raise MissingPartError(f"ROS ({error}), for `planner: {MOVE_GROUP}`", "pip install 'grip-bt[ros]'") from None

    file = project.file
    settings = file.ros.move_group if file.ros is not None else MoveGroupConfig()

    if bus is None:
        bus = stack.enter_context(Bus("grip_planning"))

    def mount(arm: ArmConfig) -> Mount:
        hand = file.hands.get(arm.hand) if arm.hand else None
        return Mount.of(description, arm.group, hand.group if hand else "", settings.groups.get(arm.group, ""))

    planner = MoveGroupPlanner(
        MoveGroup(bus, settings.namespace, settings.wait),
        description,
        {arm.group: mount(arm) for arm in file.arms.values() if arm.planner == MOVE_GROUP},
        {arm.hand: mount(arm) for arm in file.arms.values() if arm.hand},
        settings.pipeline,
        settings.planner,
        settings.by_service,
    )
    return PlannerByName(own, {MOVE_GROUP: stack.enter_context(planner)})
