"""Which adapters a run gets: the one place that picks between the simulator, fakes and ROS 2."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.base.errors import DocumentError, UnknownNameError
from grip_bt.base.message_store import LocalMessages, MessageLibrary, load, save
from grip_bt.runtime import TreeRun
from grip_bt.runtime.value_codec import decode, encode

from ..project.config import ARCHIVE, MESSAGES
from ..project.folder import Project, find_project
from .parts import Progress, Resources, RobotKind, silent

if TYPE_CHECKING:
    pass


@contextmanager
def open_resources(
    project: Project,
    needs: Collection[str],
    robot: str,
    seed: int,
    pace: float | None,
    progress: Progress,
    hold: int | None = None,
    own: Collection[str] = (),
) -> Iterator[Resources]:
    """Start what the nodes in `needs` ask for; everything is closed again at the end, in reverse order.

    Args:
        project: whose robot, sensors and components.
        needs: catalogue ids of the task's leaves.
        robot: `sim`, `fake`, or `ros` for the controllers that the project names.
        seed: of the simulated world.
        pace: simulated seconds per second; None for as fast as it goes.
        progress: told of each part that came up.
        hold: file descriptor over which somebody else may have the robot hold; None for nobody.
        own: implementations of leaves, in which it is looked what the project's own nodes ask for.
    """
    from . import fake, simulated

    with ExitStack() as stack:
        resources, asked = Resources(), parts_asked_for(own)
        needs_robot = bool(asked & ROBOT) or any(_needs_robot(project, node) for node in needs)
        if needs_robot and robot == "fake":
            fake.open_robot(project, resources)
        elif needs_robot and project.file.robot is not None:
            if robot == "sim":
                simulated.open_robot(project, resources, seed, pace, stack, progress, hold)
            elif robot == "ros":
                from . import ros_robot

                ros_robot.open_robot(project, resources, seed, stack, progress)
            else:
                raise UnknownNameError("robot", robot, ("sim", "fake", "ros"))
        elif any(node.partition("/")[0] in _MOVING_NODES for node in needs):
            raise DocumentError(_NO_ROBOT, str(project.folder / "grip.yaml"))
        names = sorted(node.partition("/")[2] for node in needs if node.startswith("component/"))
        if names and robot == "fake":
            fake.open_components(project, names, resources)
            names = []
        sensors = [n for n in _sensors(needs) if n in project.file.sensors and project.file.sensors[n].topics]
        asks_ros = bool(sensors) or any(node.startswith("ros/") for node in needs)
        if asks_ros and robot == "fake":
            fake.open_ros(project, sensors, resources)
        elif names or asks_ros:
            from . import ros

            ros.open_ros(project, names, sensors, needs, resources, stack, progress)
        if "messages" in asked or any(node.startswith("messages/") for node in needs):
            open_messages(project, resources, stack, progress, server=robot != "fake")
        yield resources


_ROBOT_NODES = ("arm", "hand", "grasp", "scene", "perception")
_MOVING_NODES = ("arm", "hand", "scene")
_NO_ROBOT = "there is no `robot:`, and the task needs one: name one (`grip robot list`), or try it with --robot fake"


def _sensors(needs: Collection[str]) -> list[str]:
    return sorted(node.partition("/")[2] for node in needs if node.startswith("sensor/"))


def _needs_robot(project: Project, node: str) -> bool:
    kind, _, name = node.partition("/")
    on_topics = kind == "sensor" and name in project.file.sensors and bool(project.file.sensors[name].topics)
    return kind in _ROBOT_NODES or (kind == "sensor" and not on_topics)


ROBOT = frozenset({"arm", "hand", "camera", "scene"})
_ASKED = re.compile(r"\.(arm|hand|camera|scene|messages)\(")


def parts_asked_for(implementations: Iterable[str]) -> frozenset[str]:
    """Return which parts the files of nodes ask their context for, such as `self.context.arm("")`.

    What a file does by way of another one isn't seen: a task that uses it needs a node that asks for the part itself.

    Args:
        implementations: `FILE.py:NAME`, as manifests have them; those in modules are left out.
    """
    files = {Path(where) for where, _, _ in (i.rpartition(":") for i in implementations) if where.endswith(".py")}
    found: set[str] = set()
    for file in files:
        if file.is_file():
            found.update(_ASKED.findall(file.read_text(encoding="utf-8", errors="replace")))
    return frozenset(found)


def open_messages(
    project: Project, resources: Resources, stack: ExitStack, progress: Progress, server: bool = True
) -> None:
    """Put the project's named messages into `resources`.

    Args:
        project: whose.
        resources: filled in.
        stack: closes what was opened.
        progress: told where they are.
        server: whether a server may be asked, where the project has one.

    Raises:
        DocumentError: a file of the project's folder `messages/` is wrong.
        ArchiveError: what an earlier run kept can't be read.
    """
    if project.file.message_server and server:
        _open_server(resources, stack, progress)
        return
    folder = project.folder / MESSAGES
    library = MessageLibrary(folder if folder.is_dir() else None)
    file = project.state_folder / ARCHIVE
    kept = load(lambda name: library.store(name, make=True), file, decode) if file.is_file() else 0
    resources.messages = LocalMessages(library, lambda: save(library.stores(), file, encode))
    named = sum(len(store) for store in library.stores().values())
    progress("messages", f"{named} by name, {kept} of them kept by an earlier run")


def _open_server(resources: Resources, stack: ExitStack, progress: Progress) -> None:
    """Ask a server that runs: it is in the user's own domain."""
    from grip_bt.ros.client.bus import Bus
    from grip_bt.ros.messages import RosMessages

    bus = stack.enter_context(Bus("grip_task_messages"))
    resources.messages = RosMessages(bus)
    progress("messages", "of the server under /grip/messages")


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
        path: a file of the project whose nodes, robot and components are meant.
        needs: catalogue ids of the nodes.
        robot: simulated, or fake parts that do as asked.
        seed: of the simulated world.
        pace: simulated seconds per second; None for as fast as it goes.
        progress: told of each part that came up.

    Raises:
        GripError: a part of the robot, or a component, can't be started.
    """
    project = find_project(path)
    with open_resources(project, needs, robot, seed, pace, progress) as resources:
        with TreeRun(resources.context(), catalogue_of(project)) as run:
            yield run
