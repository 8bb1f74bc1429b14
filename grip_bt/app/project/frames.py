"""Frames that sensors and components name and that nothing in the project's files has: told before a run."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path

from grip_bt.base.errors import DocumentError, GripError, UnknownNameError, nearest
from grip_bt.ros.frames import FrameTree
from grip_bt.task.catalog.component_file import ComponentFile, load_component
from grip_bt.task.catalog.component_parts import ProcessConfig
from grip_bt.task.catalog.project_parts import UNFIT, Trouble
from grip_bt.task.validation.codes import suggestion

from .folder import Project

ROOT = "world"
_PUBLISHER = "static_transform_publisher"
_OPTIONS = ("--frame-id", "--child-frame-id")
_SAID = re.compile(r"--(?:child-)?frame-id[\s\"',]+([A-Za-z_/][\w/.-]*)")
"""A frame of a static publisher in the text of a launch file, in any of its three languages."""
_POSITIONAL = (8, 9)
"""How many words its older form has: a position, angles or a quaternion, and then the two frames."""
_LARGEST = 1_000_000
"""Of a launch file's text that is looked through."""


def frames_in_doubt(project: Project, links: Collection[str], robot_known: bool) -> dict[str, tuple[Trouble, ...]]:
    """Return, by node, which frames are named that nothing has, as far as files tell.

    Args:
        project: whose sensors and components.
        links: of its robot.
        robot_known: False where the robot couldn't be read: nothing is known of its links then.

    Returns:
        id of a node -> what is wrong with it. Nothing is said where the project declares no frame at all, neither by a
        robot nor by a mount: then all of them are somebody else's.
    """
    mounted = _mounted(project, bool(links))
    if not robot_known or not (links or mounted):
        return {}
    fixed = {ROOT, *links, *mounted}
    found: dict[str, tuple[Trouble, ...]] = {}
    given = {n: s.given_in for n, s in project.file.sensors.items() if s.topics and s.given_in is not None}
    published = fixed | _published(project) if given else fixed
    for name, frame in given.items():
        where = f"grip.yaml: sensors/{name}/given_in"
        found[f"sensor/{name}"] = tuple(_unknown([(where, frame)], published, by_tf=True))
    for file, named in _named_by_components(project):
        found[f"component/{file.name}"] = tuple(_unknown(named, fixed, by_tf=False))
    return found


def _unknown(named: Iterable[tuple[str, str]], known: Collection[str], by_tf: bool) -> Iterator[Trouble]:
    """Yield the frames that aren't known; with `by_tf` there may be more of them when the task runs."""
    for where, frame in named:
        if frame in known:
            continue
        doubt = "; only TF could have it, when the task runs" if by_tf else "; TF isn't asked for a component's frames"
        otherwise = "name one of these, or see that TF publishes it" if by_tf else "name one of these"
        fix = suggestion(nearest(frame, tuple(sorted(known))), otherwise)
        yield Trouble(UNFIT, f"{UnknownNameError('frame', frame, known, where)}{doubt}", fix)


def _mounted(project: Project, on_links: bool) -> set[str]:
    """Return the frames of the sensors; without a robot also what they are mounted on, since that is all there is."""
    mounts = [sensor.mount for sensor in project.file.sensors.values() if sensor.mount is not None]
    return {frame for mount in mounts for frame in ((mount.frame,) if on_links else (mount.frame, mount.on))}


def _named_by_components(project: Project) -> Iterator[tuple[ComponentFile, list[tuple[str, str]]]]:
    for name, folder in project.component_folders().items():
        try:
            file = load_component(folder)
        except DocumentError:
            continue  # the project's catalogue says so
        where = f"components/{name}/component.yaml: ports"
        yield file, [(f"{where}/{p}/frame", port.frame) for p, port in file.ports.items() if port.frame is not None]


def _published(project: Project) -> set[str]:
    """Return the frames that static publishers among the project's processes have, as far as they can be read."""
    found: set[str] = set()
    for process in project.file.processes.values():
        if process.launch is not None and process.package is None:
            found.update(_frames_in_text(project.folder / process.launch))
        else:
            found.update(_frames_of_publisher(process))
    return {frame.lstrip("/") for frame in found}


def _frames_of_publisher(process: ProcessConfig) -> list[str]:
    words = list(process.args)
    if process.executable != _PUBLISHER:
        if _PUBLISHER not in process.command:
            return []
        words = list(process.command[process.command.index(_PUBLISHER) + 1 :])
    if "--ros-args" in words:
        words = words[: words.index("--ros-args")]
    said = [after for word, after in zip(words, words[1:], strict=False) if word in _OPTIONS]
    return said or (words[-2:] if len(words) in _POSITIONAL else [])


def _frames_in_text(path: Path) -> list[str]:
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            text = file.read(_LARGEST)
    except OSError:
        return []  # a run says that it isn't there
    return _SAID.findall(text) if _PUBLISHER in text else []


def robot_frames(project: Project) -> FrameTree:
    """Return the links of the project's robot that never move, as far as its description can be had here."""
    if project.file.robot is None:
        return FrameTree()
    try:
        return FrameTree.of_urdf(project.description().urdf)
    except (ImportError, GripError):
        return FrameTree()
