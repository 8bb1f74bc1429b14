"""What a project's arms and hands name: whether the robot has it. Nothing is started, and no motion library loaded."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from grip_bt.app.project.folder import ArmConfig, Project
from grip_bt.app.project.worlds import checked_world
from grip_bt.base.errors import DocumentError, GripError, UnknownNameError
from grip_bt.base.values import JointState
from grip_bt.commanders.description.file_cache import FileCache, note
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.scene_file import load_scene
from grip_bt.commanders.settings import PLANNERS, SOLVERS
from grip_bt.task.catalog.ros_config import MOVE_GROUP
from grip_sim.faults import check_faults
from grip_sim.specs import WorldSpec
from grip_sim.worlds import world_files

TAUGHT = "taught.yaml"
"""File of a project in which taught states and poses are kept."""


def check(faults: Iterable[GripError]) -> None:
    """Raise the first of what is wrong, before anything is started."""
    for fault in faults:
        raise fault


def faults_of_parts(project: Project, robot: RobotDescription) -> Iterator[GripError]:
    """Yield what is wrong with what the project's arms and hands name."""
    for name in project.file.arms:
        yield from faults_of_arm(project, name, robot)
    for name in project.file.hands:
        yield from faults_of_hand(project, name, robot)


def faults_of_arm(project: Project, name: str, robot: RobotDescription) -> Iterator[GripError]:
    """Yield what is wrong with what an arm names, all of it."""
    arm, arms, where = project.file.arms[name], project.file.arms, f"grip.yaml: arms/{name}"
    yield from _faults_of_group(arm.group, robot, where)
    if arm.hand is not None and arm.hand not in project.file.hands:
        yield UnknownNameError("hand", arm.hand, project.file.hands, f"{where}/hand")
    yield from faults_of_fields(arm, robot, where)
    others = set(arms) - {name}
    strange = [part for part in arm.arms if part not in others]
    yield from (UnknownNameError("arm", part, others, f"{where}/arms") for part in strange)
    groups = [arm.group, *(arms[part].group for part in arm.arms if part in others)]
    if arm.arms and not strange and all(group in robot.groups for group in groups):
        if set(robot.group(arm.group)) != {joint for group in groups[1:] for joint in robot.group(group)}:
            joined = ", ".join(arm.arms)
            yield GripError(f"{where}/arms: the group {arm.group!r} holds other joints than {joined} together")


def faults_of_hand(project: Project, name: str, robot: RobotDescription) -> Iterator[GripError]:
    """Yield what is wrong with what a hand names."""
    return _faults_of_group(project.file.hands[name].group, robot, f"grip.yaml: hands/{name}")


def _faults_of_group(group: str, robot: RobotDescription, where: str) -> Iterator[GripError]:
    if group not in robot.groups:
        yield UnknownNameError("group", group, robot.groups, f"{where}/group, robot {robot.name}")


def faults_of_fields(arm: ArmConfig, robot: RobotDescription, where: str) -> Iterator[GripError]:
    """Yield what an arm asks for, by its own fields or what the robot's files prefer, and isn't there."""
    solver, planner = field_of(arm, robot, "kinematics"), field_of(arm, robot, "planner")
    if solver not in SOLVERS:
        yield UnknownNameError("kinematics solver", solver, SOLVERS, where)
    if planner not in PLANNERS and planner != MOVE_GROUP:
        yield UnknownNameError("planner", planner, (*PLANNERS, MOVE_GROUP), where)
    unlimited = [joint for joint in robot.groups.get(arm.group, ()) if joint not in robot.jerk_limits]
    if arm.jerk is not None and unlimited:
        yield GripError(
            f"{where}: jerk is a part of the joints' jerk limits, and those of {', '.join(unlimited)} aren't known; "
            "give them `max_jerk` in joint_limits.yaml, or leave the field out"
        )


def field_of(arm: ArmConfig, robot: RobotDescription, name: str) -> Any:
    """Return a field of an arm: as `grip.yaml` says, else as the robot's files prefer, else its default."""
    preferred = robot.preferences.get(arm.group, {}).get(name)
    if name in arm.model_fields_set or preferred is None or preferred.value is None:
        return getattr(arm, name)
    return preferred.value


def jerks_of_arms(arms: Mapping[str, ArmConfig], robot: RobotDescription) -> dict[str, float]:
    """Return joint -> jerk limit [rad/s^3] of the arms that say `jerk`; of a joint of two of them the smaller one."""
    found: dict[str, float] = {}
    for arm in arms.values():
        for joint in robot.groups.get(arm.group, ()) if arm.jerk is not None else ():
            found[joint] = min(found.get(joint, np.inf), robot.jerk_limits.get(joint, np.inf) * (arm.jerk or 1.0))
    return {joint: limit for joint, limit in found.items() if np.isfinite(limit)}


def common_states(arm: ArmConfig, arms: Mapping[str, ArmConfig], robot: RobotDescription) -> dict[str, JointState]:
    """Return the states that all arms which an arm joins have by the same name, such as `home`."""
    parts = [robot.named_states.get(arms[name].group, {}) for name in arm.arms if name in arms]
    names = set.intersection(*(set(part) for part in parts)) if parts else set()
    joined = {name: [part[name] for part in parts] for name in sorted(names)}
    return {
        name: JointState([j for each in states for j in each.names], np.concatenate([s.position for s in states]))
        for name, states in joined.items()
    }


_scenes: FileCache[Path, DocumentError | None] = FileCache()
"""`.scene` files, and what is wrong with them."""


def faults_of_simulation(project: Project) -> Iterator[GripError]:
    """Yield what keeps the project's world from being simulated: the world, its scene, its cameras."""
    if project.file.world is None:
        yield UnknownNameError("world", "", world_files(project.folder), "grip.yaml: world")
    yield from faults_of_world(project)
    yield from faults_of_cameras(project)


def faults_of_cameras(project: Project, world: str | None = None) -> Iterator[GripError]:
    """Yield the cameras that sensors name and the project's world, or another one, doesn't have."""
    for name in project.file.sensors:
        yield from faults_of_camera(project, name, world)


def faults_of_world(project: Project) -> Iterator[GripError]:
    """Yield what is wrong with `world:` and `scene:`; nothing of those that the project doesn't have."""
    world = project.file.world
    found = None if world is None else checked_world(project, world)
    if isinstance(found, UnknownNameError) and found.kind == "world":
        yield UnknownNameError("world", world or "", world_files(project.folder), "grip.yaml: world")
    elif isinstance(found, GripError):
        yield found
    if project.file.scene is not None:
        file = project.folder / project.file.scene
        error = _scenes.get(file, lambda: _fault_of_scene(file))
        if error is not None:
            yield error


def faults_of_faults(project: Project, spec: WorldSpec, robot: RobotDescription) -> Iterator[GripError]:
    """Yield the faults of a world, what is to go wrong on purpose, that name what isn't there."""
    objects, cameras = [thing.name for thing in spec.objects], [camera.name for camera in spec.cameras]
    return check_faults(spec.faults, robot, objects, cameras, project.component_folders())


def faults_of_camera(project: Project, sensor: str, world: str | None = None) -> Iterator[UnknownNameError]:
    """Yield that a world, the project's own where none is given, has no such camera as a sensor names.

    Nothing is said where no world is named, or an unknown one: a camera of the robot itself needs no world.
    """
    camera, world = project.file.sensors[sensor].camera, world or project.file.world
    spec = None if camera is None or world is None else checked_world(project, world)
    if camera is None or spec is None or isinstance(spec, GripError):
        return
    cameras = tuple(camera.name for camera in spec.cameras)
    if camera not in cameras:
        yield UnknownNameError("camera", camera, cameras, f"grip.yaml: sensors/{sensor}/camera, world {world!r}")


def _fault_of_scene(file: Path) -> DocumentError | None:
    note(file)
    try:
        load_scene(file)
    except DocumentError as error:
        return error
    return None
