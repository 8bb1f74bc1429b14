"""Which adapters a run gets: the one place that picks between the simulator, fakes and ROS 2."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import get_args

from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.app.project.folder import ARCHIVE, MESSAGES, Project, find_project
from grip_bt.app.wiring.fake import FakeMessages, fake_components, fake_ros
from grip_bt.app.wiring.parts import FakeState, Opening, OpenRobot, Progress, Resources, RobotKind, load_part, silent
from grip_bt.base.errors import DocumentError, UnknownNameError
from grip_bt.base.message_store import LocalMessages, MessageLibrary, load, save
from grip_bt.base.ports import Messages
from grip_bt.base.value_codec import decode, encode
from grip_bt.runtime import TreeRun

BACKENDS = {
    "fake": ("fake", "open_fakes", "motion"),
    "sim": ("commanders", "open_simulated", "sim"),
    "ros": ("ros_robot", "open_controllers", "motion,ros"),
}
"""Robot -> module, function, and the extras that it needs."""


def backend_of(robot: str) -> OpenRobot:
    """Return who provides a robot; what it needs is loaded here.

    Raises:
        UnknownNameError: there is no such robot.
        MissingPartError: what it needs isn't installed.
    """
    if robot not in BACKENDS:
        raise UnknownNameError("robot", robot, BACKENDS)
    module, name, extra = BACKENDS[robot]
    opens: OpenRobot = getattr(load_part(module, f"--robot {robot}", extra), name)
    return opens


@contextmanager
def open_resources(
    opening: Opening, needs: Collection[str], robot: str, own: Collection[str] = ()
) -> Iterator[Resources]:
    """Start what the nodes in `needs` ask for; everything is closed again at the end, in reverse order.

    Args:
        needs: catalogue ids of the task's leaves.
        own: implementations of leaves, in which it is looked what the project's own nodes ask for.
    """
    if robot not in get_args(RobotKind):
        raise UnknownNameError("kind of robot", robot, get_args(RobotKind))
    project, asked, parts = opening.project, _parts_asked_for(own), Resources()
    names = sorted(node.partition("/")[2] for node in {*needs, *asked} if node.startswith("component/"))
    sensors = [n for n, s in sorted(project.file.sensors.items()) if f"sensor/{n}" in needs and s.topics]
    asks_ros = bool(sensors) or any(node.startswith("ros/") for node in needs)
    needs_robot = bool(asked & ROBOT) or any(_needs_robot(project, node) for node in needs)
    # what isn't installed is said before anything is started
    opens = backend_of(robot) if needs_robot and (robot == "fake" or project.file.robot is not None) else None
    with_ros = load_part("ros", "ROS", "ros") if robot != "fake" and (names or asks_ros) else None
    with ExitStack() as stack:
        if not opening.equipment.lasting:
            stack.enter_context(opening.equipment)
        if opens is not None:
            parts = opens(opening, stack)
        elif any(node.partition("/")[0] in _MOVING_NODES for node in needs):
            raise DocumentError(_NO_ROBOT, str(project.folder / "grip.yaml"))
        if robot == "fake":
            if names:
                components = fake_components(project, names)
                fakes = replace(parts.fakes or FakeState(), components=components)
                parts = replace(parts, components=components, fakes=fakes)
            if asks_ros:
                ros, made = fake_ros(project, sensors)
                parts = replace(parts, ros=ros, sensors=made)
        elif with_ros is not None:
            of_ros = with_ros.open_ros(opening, names, sensors, needs, stack)
            clock = of_ros.clock or parts.clock
            parts = replace(
                parts,
                components=of_ros.components,
                sensors=of_ros.sensors,
                ros=of_ros.ros,
                clock=clock,
                servers=of_ros.servers,
            )
        if "messages" in asked or any(node.startswith("messages/") for node in needs):
            messages = _open_messages(opening, stack, server=robot != "fake")
            if isinstance(messages, LocalMessages) and robot == "fake":
                arms = parts.fakes.arms if parts.fakes is not None else {}
                messages = FakeMessages(messages, arms.values(), opening.progress)
            parts = replace(parts, messages=messages)
        yield parts


_ROBOT_NODES = ("arm", "hand", "grasp", "scene", "perception")
_MOVING_NODES = ("arm", "hand", "scene")
_NO_ROBOT = "there is no `robot:`, and the task needs one: name one (`grip robot list`), or try it with --robot fake"


def _needs_robot(project: Project, node: str) -> bool:
    kind, _, name = node.partition("/")
    on_topics = kind == "sensor" and name in project.file.sensors and bool(project.file.sensors[name].topics)
    return kind in _ROBOT_NODES or (kind == "sensor" and not on_topics)


ROBOT = frozenset({"arm", "hand", "camera", "scene"})
_ASKED = re.compile(r"\.(arm|hand|camera|scene|messages)\(")
_COMPONENT = re.compile(r"""\.component\(["'](\w+)["']""")


def _parts_asked_for(implementations: Iterable[str]) -> frozenset[str]:
    """Return which parts the files of nodes ask their context for: `hand`, `component/NAME`.

    What a file does by way of another one isn't seen: a task that uses it needs a node that asks for the part itself.
    """
    files = {Path(where) for where, _, _ in (i.rpartition(":") for i in implementations) if where.endswith(".py")}
    found: set[str] = set()
    for file in files:
        if file.is_file():
            text = file.read_text(encoding="utf-8", errors="replace")
            found.update(_ASKED.findall(text), (f"component/{name}" for name in _COMPONENT.findall(text)))
    return frozenset(found)


def _open_messages(opening: Opening, stack: ExitStack, server: bool = True) -> Messages:
    """Return the project's named messages; those of a running server only with `server`.

    Raises:
        DocumentError: a file of the project's folder `messages/` is wrong.
        ArchiveError: what an earlier run kept can't be read.
    """
    project = opening.project
    if project.file.message_server and server:
        messages: Messages = load_part("ros", "ROS", "ros").connect_messages(stack)
        opening.progress("messages", "of the server under /grip/messages")
        return messages
    folder = project.folder / MESSAGES
    library = MessageLibrary(folder if folder.is_dir() else None)
    file = project.state_folder / ARCHIVE
    kept = load(lambda name: library.store(name, make=True), file, decode) if file.is_file() else 0
    named = sum(len(store) for store in library.stores().values())
    opening.progress("messages", f"{named} by name, {kept} of them kept by an earlier run")
    return LocalMessages(library, lambda: save(library.stores(), file, encode))


@contextmanager
def tree_run(
    path: str | Path,
    needs: Collection[str] = (),
    *,
    robot: RobotKind = "sim",
    seed: int = 0,
    pace: float | None = None,
    progress: Progress = silent,
) -> Iterator[TreeRun]:
    """Start what the nodes of a machine need; everything is closed at the end.

    Args:
        needs: catalogue ids of the nodes.

    Raises:
        GripError: a part of the robot, or a component, can't be started.
    """
    project = find_project(path)
    with open_resources(Opening(project, seed, pace, progress), needs, robot) as resources:
        with TreeRun(resources.context(), catalogue_of(project)) as run:
            yield run
