"""The commanders of a project's arms and hands, over whatever moves their joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from grip_bt.errors import UnknownNameError
from grip_bt.ports import Executor, HandPort
from grip_bt.values import JointState, Pose

from .project import ArmConfig, Project
from .resources import Resources

if TYPE_CHECKING:
    from grip_bt.commanders.robots import RobotDescription
    from grip_bt.commanders.worker import PlanningService

TAUGHT = "taught.yaml"
"""File of a project in which taught states and poses are kept."""


def open_commanders(
    project: Project,
    resources: Resources,
    description: RobotDescription,
    planner: PlanningService,
    executors: Mapping[str, Executor],
    ports: Mapping[str, HandPort],
    boxes: Mapping[str, tuple[Sequence[float], Pose]],
    seed: int,
) -> None:
    """Put the project's arms, hands and scene into `resources`.

    Args:
        project: whose arms and hands.
        resources: filled in.
        description: the robot.
        planner: makes the plans.
        executors: what moves each arm.
        ports: what moves each hand.
        boxes: of the world: name -> (edge lengths [m], pose).
        seed: of the planners.

    Raises:
        UnknownNameError: the project names a group or a hand that isn't there.
    """
    from grip_bt.commanders.arm import ArmCommander
    from grip_bt.commanders.hand import HandCommander
    from grip_bt.commanders.model import RobotModel
    from grip_bt.commanders.planning.requests import PlanningSettings
    from grip_bt.commanders.robot_links import joints_of_fingers, limits_of_joints, links_of_groups
    from grip_bt.commanders.scene import PlanningScene
    from grip_bt.commanders.taught import Taught

    file = project.file
    model, taught = RobotModel(description), Taught(project.folder / TAUGHT)
    resources.hands = {
        name: HandCommander(
            name,
            ports[name],
            _states_of(description, hand.group),
            fingers=joints_of_fingers(description, hand.group),
            limits=limits_of_joints(description, hand.group),
            taught=taught,
        )
        for name, hand in file.hands.items()
    }
    hand_of = {name: _hand_of(name, arm, file.hands) for name, arm in file.arms.items()}
    scene = PlanningScene(
        {
            hand: lambda arm=arm: model.grasp_pose(executors[arm].state(), group=file.arms[arm].group)
            for arm, hand in hand_of.items()
            if hand
        },
        boxes,
        project.room(),
        links_of_groups(description, {name: part.group for name, part in (*file.arms.items(), *file.hands.items())}),
        project.folder,
    )
    resources.arms = {
        arm: ArmCommander(
            arm,
            model,
            planner,
            executors[arm],
            scene,
            hand,
            ports[hand].state if hand else _no_joints,
            PlanningSettings(
                planner=file.arms[arm].planner,
                kinematics=file.arms[arm].kinematics,
                speed=file.arms[arm].speed,
                acceleration=file.arms[arm].acceleration,
                time_limit=file.arms[arm].planning_time,
                attempts=file.arms[arm].attempts,
                seed=seed,
            ),
            file.arms[arm].group,
            taught,
        )
        for arm, hand in hand_of.items()
    }
    resources.scene = scene


def _hand_of(name: str, arm: ArmConfig, hands: Mapping[str, object]) -> str:
    if arm.hand is None:
        return ""  # a bare arm: it moves, and grasps nothing
    if arm.hand not in hands:
        raise UnknownNameError("hand", arm.hand, hands, f"grip.yaml: arms/{name}/hand")
    return arm.hand


def _states_of(description: RobotDescription, group: str) -> Mapping[str, JointState]:
    description.group(group)
    return description.named_states.get(group, {})


def _no_joints() -> JointState:
    return JointState((), ())
