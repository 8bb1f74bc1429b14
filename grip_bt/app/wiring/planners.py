"""Who plans for a project's arms: the planning process, MoveIt's move_group, or each for some of them."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from grip_bt.app.project.folder import ArmConfig
from grip_bt.base.operation import Operation
from grip_bt.base.values import Plan
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.planning.requests import (
    ChooseGrasp,
    ChosenGrasp,
    PlanningService,
    PlanStraight,
    PlanThrough,
    PlanTo,
    Request,
    Searcher,
)
from grip_bt.commanders.settings import MotionSettings, PlanningSettings
from grip_bt.task.catalog.ros_config import MOVE_GROUP

from ..project.faults import check, faults_of_fields, field_of
from ..project.folder import Project
from .parts import Opening, load_part

if TYPE_CHECKING:
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
        situation = request.situation
        if isinstance(request, PlanThrough) and situation.settings.planner in self._others:
            usual = situation.settings.model_copy(update={"planner": PlanningSettings().planner})
            request = replace(request, situation=replace(situation, settings=usual))
        if isinstance(request, PlanTo | PlanStraight | ChooseGrasp):
            return self._others.get(request.situation.settings.planner, self._own).submit(request)
        return self._own.submit(request)


def planners_in_force(project: Project, description: RobotDescription) -> str:
    """Return the names of the planners that the project's arms are planned for with, for people."""
    return ", ".join(sorted({settings_of(arm, description, 0).planner for arm in project.file.arms.values()}))


def with_move_group(
    opening: Opening, description: RobotDescription, own: PlanningService, stack: ExitStack, bus: Bus | None = None
) -> PlanningService:
    """Return a planner that has MoveIt answer for the arms that say so.

    Args:
        bus: the connection to ROS; one of its own, in the user's domain, when there is none.

    Raises:
        MissingPartError: ROS isn't installed, or MoveIt's messages aren't and can't be built.
        UnknownNameError: an arm names a hand or a group that isn't there.
    """
    if all(arm.planner != MOVE_GROUP for arm in opening.project.file.arms.values()):
        return own
    loaded = load_part("ros", f"ROS, for `planner: {MOVE_GROUP}`", "ros")
    return PlannerByName(own, {MOVE_GROUP: loaded.open_move_group(opening.project, description, stack, bus)})


def settings_of(arm: ArmConfig, robot: RobotDescription, seed: int) -> PlanningSettings:
    """Return how an arm is planned for: its fields in `grip.yaml`, else what the robot's files say, else defaults.

    Raises:
        UnknownNameError: there is no such solver or planner.
    """
    check(faults_of_fields(arm, robot, "grip.yaml: arms"))

    def field(name: str) -> Any:
        return field_of(arm, robot, name)

    planner = field("planner")
    configured = robot.preferences.get(arm.group, {}).get("planner")
    parameters = {} if configured is None else configured.parameters.get(planner, {})
    asked = {name: getattr(arm, name) for name in MotionSettings.model_fields}
    preferred = {name: field(name) for name in ("planner", "kinematics", "speed", "acceleration")}
    return PlanningSettings(**{**asked, **preferred}, seed=seed, parameters=tuple(parameters.items()))
