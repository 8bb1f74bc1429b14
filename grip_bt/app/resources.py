"""Which adapters a run gets: the one place that picks between the simulator, fakes and ROS 2."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import Any

from grip_bt.errors import UnknownNameError
from grip_bt.ports import Arm, Camera, Clock, Component, Hand, Pausable, Scene

from .domain import own_domain
from .project import Project

Progress = Callable[[str, str], None]
"""Told `(part, detail)` as parts come up."""


def silent(part: str, detail: str) -> None:
    """Say nothing."""


@dataclass
class Resources:
    """The parts that a run offers to its leaves, and the referee, which it doesn't."""

    clock: Clock | None = None
    arms: Mapping[str, Arm] = field(default_factory=dict)
    hands: Mapping[str, Hand] = field(default_factory=dict)
    cameras: Mapping[str, Camera] = field(default_factory=dict)
    components: Mapping[str, Component] = field(default_factory=dict)
    scene: Scene | None = None
    referee: Any = None
    pausable: Sequence[Pausable] = ()


@contextmanager
def open_resources(
    project: Project,
    needs: Collection[str],
    robot: str,
    seed: int,
    pace: float | None,
    progress: Progress,
    hold: int | None = None,
) -> Iterator[Resources]:
    """Start what the nodes in `needs` ask for; everything is closed again at the end, in reverse order.

    Args:
        project: whose robot, sensors and components.
        needs: catalogue ids of the task's leaves.
        robot: `sim` or `fake`.
        seed: of the simulated world.
        pace: simulated seconds per second; None for as fast as it goes.
        progress: told of each part that came up.
        hold: file descriptor over which somebody else may have the robot hold; None for nobody.
    """
    from . import fake_parts, simulated_parts

    with ExitStack() as stack:
        resources = Resources()
        if any(node.split("/")[0] in _ROBOT_NODES for node in needs) and project.file.robot is not None:
            if robot == "fake":
                fake_parts.open_robot(project, resources)
            elif robot == "sim":
                simulated_parts.open_robot(project, resources, seed, pace, stack, progress, hold)
            else:
                raise UnknownNameError("robot", robot, ("sim", "fake"))
        names = sorted(node.partition("/")[2] for node in needs if node.startswith("component/"))
        if names and robot == "fake":
            fake_parts.open_components(project, names, resources)
        elif names:
            _open_components(project, names, resources, stack, progress)
        yield resources


_ROBOT_NODES = ("arm", "hand", "grasp", "scene", "sensor", "perception")


def _open_components(
    project: Project, names: list[str], resources: Resources, stack: ExitStack, progress: Progress
) -> None:
    from grip_bt.ros.components import start_components

    folder = project.file.components or "components"
    components = start_components(project.folder, names, stack.enter_context(own_domain()), folder)
    stack.callback(components.close)
    resources.components = {name: components.client(name) for name in names}
    built = (
        f"interfaces built in {components.build_seconds:.1f} s" if components.build_seconds else "interfaces in cache"
    )
    for name in names:
        process = components.process(name)
        where = f"process {process.pid}" if process is not None else "already running"
        progress("component", f"{name}: ROS 2 server in {where}, ready after {components.ready_seconds:.1f} s; {built}")
