"""What a project's robot, sensors and components have, for the check of its tasks: read from files alone."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

from grip_bt.app.project.folder import ARCHIVE, MESSAGES, Project
from grip_bt.app.project.needs import nodes_in_need, packages_here
from grip_bt.base.errors import DocumentError, GripError, MissingPartError, UnknownNameError
from grip_bt.base.message_store import MessageLibrary, names
from grip_bt.commanders.description.file_cache import FileCache
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.description.tree import Tree, joints_of_fingers, links_of_groups
from grip_bt.commanders.taught import TaughtStates
from grip_bt.task.catalog.project_parts import NO_CONTROLLER, UNFIT_PROJECT, PartNames, Problem, ProjectParts

from .faults import TAUGHT, common_states, faults_of_arm, faults_of_camera, faults_of_hand, faults_of_world

Known = dict[str, Iterable[str]]
"""Kind of names -> those that a part of the robot has."""
_robots: FileCache[tuple[str, str], RobotDescription | GripError | None] = FileCache()
"""Folder and `robot:` of a project -> the robot, or what is wrong with it."""


def project_parts_of(project: Project) -> ProjectParts:
    """Return what a project has, as far as its files tell."""
    file, problems = project.file, tuple[Problem, ...]()
    key = str(project.folder), repr(file.robot)
    found = None if file.robot is None else _robots.get(key, lambda: _robot(project))
    if isinstance(found, GripError):
        problems = (_problem(found, "`grip robot check` lists all that is wrong with it"),)
    world = [_problem(fault) for fault in faults_of_world(project)]
    robot = None if isinstance(found, GripError) else found
    links = () if robot is None else Tree.of(robot.urdf).links
    packages = packages_here(project)
    needs = nodes_in_need(project, packages, links, robot is not None or file.robot is None)
    for name in file.sensors:
        needs[f"sensor/{name}"] += _faults_of_sensor(project, name, links, world)
    nodes = {node: tuple(found) for node, found in needs.items()}
    if file.robot is None and not file.arms and not file.hands:
        return ProjectParts(nodes=nodes, packages=packages)  # a task can be drawn before there is a robot
    problems, taught = (*problems, *world), None
    try:
        taught = TaughtStates(project.folder / TAUGHT)
    except DocumentError as error:
        problems = (*problems, _problem(error))
    arms, hands = dict[str, PartNames](), dict[str, PartNames]()
    for name, arm in file.arms.items():
        known: Known = {} if taught is None else {"taught": taught.of(name)}
        if robot is not None and taught is not None:
            known |= _names_of_arm(project, name, robot, taught)
        wrong = () if robot is None else faults_of_arm(project, name, robot)
        arms[name] = _part_names(known, [*problems, *map(_problem, wrong), *_uncontrolled(project, name, arm.arms)])
    for name, hand in file.hands.items():
        known = {} if robot is None or taught is None else _names_of_hand(name, hand.group, robot, taught, links)
        wrong = () if robot is None else faults_of_hand(project, name, robot)
        hands[name] = _part_names(known, [*problems, *map(_problem, wrong), *_uncontrolled(project, name)])
    return ProjectParts(arms, hands, nodes, packages)


def _robot(project: Project) -> RobotDescription | GripError | None:
    """Return the robot, or what is wrong with it; None where there is none, or its models aren't installed."""
    try:
        return project.description()
    except (MissingPartError, ImportError):
        return None  # a task can be drawn where the robot isn't installed
    except GripError as error:
        return error


def _names_of_arm(project: Project, name: str, robot: RobotDescription, taught: TaughtStates) -> Known:
    arm = project.file.arms[name]
    states = {**robot.named_states.get(arm.group, {}), **common_states(arm, project.file.arms, robot)}
    return {"state": {**states, **taught.states(name)}} if arm.group in robot.groups else {}


def _names_of_hand(name: str, group: str, robot: RobotDescription, taught: TaughtStates, links: Sequence[str]) -> Known:
    if group not in robot.groups:
        return {}
    fingers = joints_of_fingers(robot, group)
    return {
        "posture": {**robot.named_states.get(group, {}), **taught.states(name)},
        "finger": fingers,
        "tip": [*fingers, *links_of_groups(robot, {name: group})[name]],
        "link": [*links, "grasp", *(f"grasp/{each}" for each in robot.grasp_frames)],
    }


def _uncontrolled(project: Project, name: str, joined: tuple[str, ...] = ()) -> list[Problem]:
    """Return that a real robot's arm or hand has no controller; one that joins others moves by theirs."""
    ros = project.file.ros
    if ros is None or joined or name in ros.controllers:
        return []
    error = UnknownNameError("controller of", name, ros.controllers, "grip.yaml: ros/controllers")
    return [Problem(NO_CONTROLLER, str(error).rstrip("."))]


def _faults_of_sensor(
    project: Project, name: str, links: Collection[str], world: Iterable[Problem]
) -> Iterator[Problem]:
    """Yield what is wrong with a sensor: its world, no such camera, a mount on no link."""
    sensor, ros = project.file.sensors[name], project.file.ros
    if sensor.camera is not None:
        yield from world
        yield from map(_problem, faults_of_camera(project, name))
    camera = None if ros is None else ros.cameras.get(name)
    mounts = {f"sensors/{name}": sensor.mount, f"ros/cameras/{name}": None if camera is None else camera.mount}
    for where, mount in mounts.items():
        if mount is not None and links and mount.on not in ("world", *links):
            yield _problem(UnknownNameError("link", mount.on, ("world", *links), f"grip.yaml: {where}/mount/on"))


def _part_names(known: Mapping[str, Iterable[str]], problems: list[Problem]) -> PartNames:
    return PartNames({kind: tuple(dict.fromkeys(names)) for kind, names in known.items()}, tuple(problems))


def _problem(error: GripError, fix: str = "") -> Problem:
    return Problem(UNFIT_PROJECT, str(error).rstrip("."), fix)


def message_names(project: Project) -> Mapping[str, set[str]] | None:
    """Return store -> names of the messages that a run begins with; None where a server or nobody knows."""
    if project.file.message_server:
        return None
    folder = project.folder / MESSAGES
    try:
        stores = MessageLibrary(folder if folder.is_dir() else None).stores()
    except DocumentError:
        return None  # a run says what is wrong with the file
    found = {name: set(store.names()) for name, store in stores.items()}
    for store, kept in names(project.folder / ".grip" / ARCHIVE).items():
        found.setdefault(store, set()).update(kept)
    return found
