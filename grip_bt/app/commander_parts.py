"""The commanders of a project's arms and hands, over whatever moves their joints."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from grip_bt.errors import GripError, UnknownNameError
from grip_bt.ports import Executor, HandPort
from grip_bt.values import JointState, Pose

from .project import ArmConfig, Project
from .resources import Resources

if TYPE_CHECKING:
    from grip_bt.commanders.model import RobotModel
    from grip_bt.commanders.planning.requests import PlanningSettings
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
    from grip_bt.commanders.robot_links import joints_of_fingers, limits_of_joints, links_of_groups
    from grip_bt.commanders.scene import Carrier, PlanningScene
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
            reach=partial(_reached, model, hand.group, _arm_group_of(name, file.arms)),
        )
        for name, hand in file.hands.items()
    }
    executors = {**executors, **joined_executors(project, description, executors)}
    hand_of = {name: _hand_of(name, arm, file.hands) for name, arm in file.arms.items()}
    groups = {name: arm.group for name, arm in file.arms.items()} | {
        name: hand.group for name, hand in file.hands.items()
    }
    links = links_of_groups(description, groups)

    def palm_of(arm: str) -> Pose:
        return model.grasp_pose(executors[arm].state(), group=file.arms[arm].group)

    scene = PlanningScene(
        {hand: partial(palm_of, arm) for arm, hand in hand_of.items() if hand},
        boxes,
        project.room(),
        links,
        project.folder,
        {
            hand: Carrier(
                file.arms[arm].group,
                frozenset((*links[hand], *description.hands.get(file.hands[hand].group, ()))),
            )
            for arm, hand in hand_of.items()
            if hand
        },
    )
    states = {name: executor.state for name, executor in executors.items()} | {n: p.state for n, p in ports.items()}
    resources.arms = {
        arm: ArmCommander(
            arm,
            model,
            planner,
            executors[arm],
            scene,
            hand,
            ports[hand].state if hand else _no_joints,
            settings_of(file.arms[arm], description, seed),
            file.arms[arm].group,
            taught,
            partial(_elsewhere, states, (arm, hand)),
            _common_states(file.arms[arm], file.arms, description),
        )
        for arm, hand in hand_of.items()
    }
    resources.scene = scene


def settings_of(arm: ArmConfig, robot: RobotDescription, seed: int) -> PlanningSettings:
    """Return how an arm is planned for: its fields in `grip.yaml`, else what the robot's files say, else defaults.

    Raises:
        UnknownNameError: there is no such solver; a wrong planner is told when it is asked.
    """
    from grip_bt.commanders.ik import SOLVERS
    from grip_bt.commanders.planning.requests import PlanningSettings

    def field(name: str) -> Any:
        preferred = robot.preferences.get(arm.group, {}).get(name)
        if name in arm.model_fields_set or preferred is None or preferred.value is None:
            return getattr(arm, name)
        return preferred.value

    if field("kinematics") not in SOLVERS:
        raise UnknownNameError("kinematics solver", field("kinematics"), SOLVERS, "grip.yaml: arms")
    planner = field("planner")
    configured = robot.preferences.get(arm.group, {}).get("planner")
    parameters = {} if configured is None else configured.parameters.get(planner, {})
    return PlanningSettings(
        planner=planner,
        kinematics=field("kinematics"),
        speed=field("speed"),
        acceleration=field("acceleration"),
        time_limit=arm.planning_time,
        attempts=arm.attempts,
        seed=seed,
        parameters=tuple(parameters.items()),
        timing=arm.timing,
    )


def joined_executors(
    project: Project, description: RobotDescription, executors: Mapping[str, Executor]
) -> dict[str, Executor]:
    """Return an executor for each arm that joins others.

    Raises:
        UnknownNameError: it joins an arm that isn't there.
        GripError: its group doesn't hold just the joints of these.
    """
    from grip_bt.commanders.together import JoinedExecutor

    joined: dict[str, Executor] = {}
    for name, arm in project.file.arms.items():
        if not arm.arms:
            continue
        where = f"grip.yaml: arms/{name}/arms"
        for part in arm.arms:
            if part not in project.file.arms or part == name:
                raise UnknownNameError("arm", part, set(project.file.arms) - {name}, where)
        joints = {j for part in arm.arms for j in description.group(project.file.arms[part].group)}
        if set(description.group(arm.group)) != joints:
            raise GripError(f"{where}: the group {arm.group!r} holds other joints than {', '.join(arm.arms)} together")
        joined[name] = JoinedExecutor(*(executors[part] for part in arm.arms))
    return joined


def _arm_group_of(hand: str, arms: Mapping[str, ArmConfig]) -> str:
    return next((arm.group for arm in arms.values() if arm.hand == hand), "")


def _reached(
    model: RobotModel,
    group: str,
    arm_group: str,
    targets: Mapping[str, Sequence[float]],
    posture: JointState,
    frame: str,
) -> JointState:
    """Return the posture that brings fingertips to positions; those in no frame are in the grasp frame of the arm."""
    from grip_bt.commanders.ik.fingertips import fingertip_posture

    places = {name: np.array(position, dtype=float) for name, position in targets.items()}
    return fingertip_posture(model, places, posture, group, frame=frame or model.grasp_frame_of(arm_group))


def _elsewhere(states: Mapping[str, Callable[[], JointState]], own: tuple[str, str]) -> list[JointState]:
    """Return the measured states of all arms and hands that have no joint in common with an arm and its hand."""
    taken = {joint for name in own if name for joint in states[name]().names}
    found = []
    for name, measure in states.items():
        state = measure() if name not in own else None
        if state is not None and not taken & set(state.names):
            taken |= set(state.names)
            found.append(state)
    return found


def _common_states(arm: ArmConfig, arms: Mapping[str, ArmConfig], robot: RobotDescription) -> dict[str, JointState]:
    """Return the states that all arms which an arm joins have by the same name, such as `home`."""
    parts = [robot.named_states.get(arms[name].group, {}) for name in arm.arms]
    names = set.intersection(*(set(part) for part in parts)) if parts else set()
    return {
        name: JointState(
            tuple(j for part in parts for j in part[name].names),
            np.concatenate([part[name].position for part in parts]),
        )
        for name in sorted(names)
    }


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
