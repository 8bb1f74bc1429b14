"""What a project's sensors and components need: ROS packages and frames, told by files, without ROS."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import cache, partial
from pathlib import Path

from grip_bt.app.project.folder import Project
from grip_bt.base.errors import DocumentError, GripError, UnknownNameError, nearest
from grip_bt.commanders.description.packages import name_of_package
from grip_bt.ros.frames import FrameTree
from grip_bt.ros.interfaces.build import DEPENDENCIES, FOLDER
from grip_bt.ros.interfaces.packages import (
    PackageError,
    executable_of,
    interface_packages,
    launch_file_of,
    search_path,
    share_folder,
)
from grip_bt.task.catalog.component_file import load_component
from grip_bt.task.catalog.project_parts import MISSING_PACKAGE, UNFIT_PROJECT, Problem, missing_package, missing_type
from grip_bt.task.catalog.start import Start
from grip_bt.task.validation.codes import suggestion

KINDS = ("msg", "srv", "action")
Packages = Mapping[str, Callable[[], frozenset[str]]]
"""Packages with interfaces -> what looks up the types of each (`msg/Pose`)."""


def packages_here(project: Project) -> Packages | None:
    """Return the packages with interfaces that a run would find; None where ROS isn't installed."""
    if importlib.util.find_spec("rclpy") is None:
        return None

    found: dict[str, list[Path]] = {}
    for path in project.folder.glob(f"{project.file.components or 'components'}/*/interfaces/**/package.xml"):
        found.setdefault(name_of_package(path.parent), []).append(path.parent)
    for package in interface_packages(search_path()):
        found.setdefault(package, []).extend(prefix / "share" / package for prefix in search_path())
    for package in DEPENDENCIES:
        found.setdefault(package, [FOLDER / package])
    return {package: cache(partial(_types_in, homes)) for package, homes in found.items()}


def _types_in(homes: Sequence[Path]) -> frozenset[str]:
    files = (file for home in homes for kind in KINDS for file in (home / kind).glob(f"*.{kind}"))
    return frozenset(f"{file.suffix[1:]}/{file.stem}" for file in files)


def nodes_in_need(
    project: Project, packages: Packages | None, links: Collection[str], robot_known: bool
) -> dict[str, list[Problem]]:
    """Return, by node of a sensor or a component, what it needs that isn't here, and frames that nothing has.

    Args:
        packages: those with interfaces that a run would find; None where ROS isn't installed.
        robot_known: False where the robot couldn't be read: nothing is known of its links then.

    Nothing is said of frames where the project declares none at all, neither by a robot nor by a mount: then all of
    them are somebody else's.
    """
    mounts = [sensor.mount for sensor in project.file.sensors.values() if sensor.mount is not None]
    mounted = {frame for mount in mounts for frame in ((mount.frame,) if links else (mount.frame, mount.on))}
    fixed = {ROOT, *links, *mounted} if robot_known and (links or mounted) else set[str]()
    found: dict[str, list[Problem]] = {}
    for name, sensor in project.file.sensors.items():
        where, types = f"grip.yaml: sensors/{name}", {topic.message_type() for topic in sensor.topics.values()}
        found[f"sensor/{name}"] = problems = _lacking(types, packages, where, True)
        problems += _unstartable(sensor.driver, packages, where)
        if fixed and sensor.topics and sensor.given_in is not None:
            problems += _unknown(f"{where}/given_in", sensor.given_in, fixed, by_tf=True)
    for name, folder in project.component_folders().items():
        where = f"components/{name}/component.yaml"
        try:
            file = load_component(folder)
        except DocumentError as error:
            said = f"{where}: a run refuses this component: {error}"
            fix = "fix the file, and run `grip component add` again"
            found[f"component/{name}"] = [Problem(UNFIT_PROJECT, said, fix)]
            continue
        found[f"component/{file.name}"] = problems = []
        if file.name != name:  # under which a run looks for it
            said = f"{where}: the component is called {file.name!r}, and its folder {name!r}, so a run cannot find it"
            fix = f"rename the folder to {file.name!r}, or write `name: {name}` and add it again"
            problems.append(Problem(UNFIT_PROJECT, said, fix))
        problems += [*_lacking({file.interface}, packages, where), *_unstartable(file.start, packages, where)]
        for port, said_of in file.ports.items() if fixed else ():
            problems += _unknown(f"{where}: ports/{port}/frame", said_of.frame, fixed, by_tf=False)
    return found


def _lacking(types: Iterable[str], packages: Packages | None, where: str, messages: bool = False) -> list[Problem]:
    if packages is None:
        return []
    found = (missing_type(type_, packages, where, messages) for type_ in sorted(types) if "/" in type_)
    return list(dict.fromkeys(problem for problem in found if problem is not None))


def _unstartable(start: Start | None, packages: Packages | None, where: str) -> list[Problem]:
    """Return that the package of the program to start isn't installed; it need not have interfaces."""
    if packages is None or start is None or not start.run or start.package is None:
        return []
    if share_folder(start.package, search_path()) is None:
        return [missing_package(start.package, packages, where)]
    try:
        if start.executable is not None:
            executable_of(start.package, start.executable)
        elif start.launch is not None:
            launch_file_of(start.package, start.launch)
    except PackageError as error:
        return [Problem(MISSING_PACKAGE, f"{where}: {error}", "name one that it has")]
    return []


ROOT = "world"


def _unknown(where: str, frame: str | None, known: Collection[str], by_tf: bool) -> list[Problem]:
    """Return that a frame isn't known; with `by_tf`, TF may have it, unless it looks like a known one misspelled."""
    if frame is None or frame in known:
        return []
    near = nearest(frame, tuple(sorted(known)))
    if by_tf and not near:
        return []
    doubt = "; only TF could provide it at run time" if by_tf else "; TF is not used for a component's frames"
    fix = suggestion(near, "name one of these")
    return [Problem(UNFIT_PROJECT, f"{UnknownNameError('frame', frame, known, where)}{doubt}", fix)]


def robot_frames(project: Project) -> FrameTree:
    """Return the links of the project's robot that never move, as far as its description can be had here."""
    if project.file.robot is None:
        return FrameTree()
    try:
        return FrameTree.of_urdf(project.description().urdf)
    except (ImportError, GripError):
        return FrameTree()
