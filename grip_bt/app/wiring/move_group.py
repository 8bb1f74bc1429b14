"""MoveIt's move_group as the planner of a project's arms. Needs ROS."""

from __future__ import annotations

from contextlib import ExitStack

from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.ros.client.bus import Bus
from grip_bt.ros.moveit import ArmMapping, MoveGroup, MoveGroupPlanner
from grip_bt.task.catalog.ros_config import MOVE_GROUP, MoveGroupConfig

from ..project.config import ArmConfig
from ..project.folder import Project


def open_move_group(
    project: Project, description: RobotDescription, stack: ExitStack, bus: Bus | None = None
) -> MoveGroupPlanner:
    """Return the planner; see `planners.with_move_group`."""
    file = project.file
    settings = file.ros.move_group if file.ros is not None else MoveGroupConfig()
    bus = bus if bus is not None else stack.enter_context(Bus("grip_planning"))

    def mount(arm: ArmConfig) -> ArmMapping:
        hand = file.hands.get(arm.hand) if arm.hand else None
        return ArmMapping.of(description, arm.group, hand.group if hand else "", settings.groups.get(arm.group, ""))

    planner = MoveGroupPlanner(
        MoveGroup(bus, settings.namespace, settings.wait),
        description,
        {arm.group: mount(arm) for arm in file.arms.values() if arm.planner == MOVE_GROUP},
        {arm.hand: mount(arm) for arm in file.arms.values() if arm.hand},
        settings.pipeline,
        settings.planner,
        settings.by_service,
    )
    return stack.enter_context(planner)
