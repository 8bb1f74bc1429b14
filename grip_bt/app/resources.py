"""Which adapters a run gets: the one place that picks between the simulator, fakes and ROS 2."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from grip_bt.base.errors import DocumentError, UnknownNameError
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Arm, Camera, Clock, Component, Hand, Messages, Pausable, Ros, Scene, Sensor
from grip_bt.base.values import JointState

from .own_needs import ROBOT, parts_asked_for
from .project import Project

if TYPE_CHECKING:
    from grip_bt.runtime import RunContext
    from grip_bt.runtime.lockstep import Lockstep

    from .fake_state import FakeState

Progress = Callable[[str, str], None]
"""Told `(part, detail)` as parts come up."""


def silent(part: str, detail: str) -> None:
    """Say nothing."""


@dataclass
class Resources:
    """The parts that a run offers to its leaves; and the referee, simulated world and fakes, which it doesn't."""

    clock: Clock | None = None
    arms: Mapping[str, Arm] = field(default_factory=dict)
    hands: Mapping[str, Hand] = field(default_factory=dict)
    cameras: Mapping[str, Camera] = field(default_factory=dict)
    components: Mapping[str, Component] = field(default_factory=dict)
    sensors: Mapping[str, Sensor] = field(default_factory=dict)
    ros: Ros | None = None
    messages: Messages | None = None
    scene: Scene | None = None
    referee: Any = None
    world: Any = None
    fakes: FakeState | None = None
    pausable: Sequence[Pausable] = ()
    lockstep: Lockstep | None = None
    measure: Callable[[Sequence[str]], Operation[JointState]] | None = None

    def context(self, clock: Clock | None = None) -> RunContext:
        """Return what a run gives to its leaves; `clock` in place of the parts' own."""
        from grip_bt.runtime import RunContext

        return RunContext(
            clock or self.clock,
            arms=self.arms,
            hands=self.hands,
            cameras=self.cameras,
            components=self.components,
            scene=self.scene,
            sensors=self.sensors,
            ros=self.ros,
            messages=self.messages,
            pausable=self.pausable,
            lockstep=self.lockstep,
            measure=self.measure,
        )


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
    from . import fake_parts, simulated_parts

    with ExitStack() as stack:
        resources, asked = Resources(), parts_asked_for(own)
        needs_robot = bool(asked & ROBOT) or any(_needs_robot(project, node) for node in needs)
        if needs_robot and robot == "fake":
            fake_parts.open_robot(project, resources)
        elif needs_robot and project.file.robot is not None:
            if robot == "sim":
                simulated_parts.open_robot(project, resources, seed, pace, stack, progress, hold)
            elif robot == "ros":
                from . import ros_robot_parts

                ros_robot_parts.open_robot(project, resources, seed, stack, progress)
            else:
                raise UnknownNameError("robot", robot, ("sim", "fake", "ros"))
        elif any(node.partition("/")[0] in _MOVING_NODES for node in needs):
            raise DocumentError(_NO_ROBOT, str(project.folder / "grip.yaml"))
        names = sorted(node.partition("/")[2] for node in needs if node.startswith("component/"))
        if names and robot == "fake":
            fake_parts.open_components(project, names, resources)
            names = []
        sensors = [n for n in _sensors(needs) if n in project.file.sensors and project.file.sensors[n].topics]
        asks_ros = bool(sensors) or any(node.startswith("ros/") for node in needs)
        if asks_ros and robot == "fake":
            fake_parts.open_ros(project, sensors, resources)
        elif names or asks_ros:
            from . import ros_parts

            ros_parts.open_ros(project, names, sensors, needs, resources, stack, progress)
        if "messages" in asked or any(node.startswith("messages/") for node in needs):
            from . import message_parts

            message_parts.open_messages(project, resources, stack, progress, server=robot != "fake")
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
