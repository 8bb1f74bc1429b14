"""A robot without a task: every node of the catalogue is a call."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.app.project.folder import FILE_NAME, Project, find_project
from grip_bt.app.project.foreign_code import refuse
from grip_bt.app.project.new_robot import new_robot
from grip_bt.app.wiring.open import open_resources
from grip_bt.app.wiring.parts import Opening, Progress, RobotKind, silent
from grip_bt.app.world import World, in_world
from grip_bt.base.errors import GripError, NodeError, NodeFailedError, UnknownNameError
from grip_bt.base.files import Closing
from grip_bt.base.ports import Arm, Camera, Hand, Scene
from grip_bt.commanders.description.packages import ROBOTS
from grip_bt.runtime import BehaviourTree, TreeRun
from grip_bt.task.catalog.manifest import InputPort, Manifest, Parameter


@dataclass(frozen=True)
class Done(Mapping[str, Any]):
    """How a node has succeeded: its outcome, and its outputs by name."""

    node: str
    outcome: str
    outputs: Mapping[str, Any]

    def __getitem__(self, name: str) -> object:
        if name not in self.outputs:
            raise UnknownNameError("output", name, self.outputs, self.node)
        return self.outputs[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.outputs)

    def __len__(self) -> int:
        return len(self.outputs)


class Robot(Closing):
    """A robot that is ready to be used, until its `close` or the end of a `with` block.

    `robot.do("arm/move_to", arm="right", state="home")` runs a node to its end. `arm`, `hand`, `camera` and `scene` are
    what nodes are made of: their methods return operations (`grip_bt.base.operation`), which one may `wait` for.

    Args:
        source: a project's folder, or a ready-made robot's name (`grip robot list`), which stands at a table.
        robot: fakes, a simulated robot, or a real one over ROS 2.
        world: of the simulation; the project's by default.
        seed: of the simulated world and the planners.
        components: external components that nodes are to ask; each is started.
        pace: simulated seconds per second; None for as fast as it goes.
        progress: told `(part, detail)` as parts come up.

    Raises:
        UnknownNameError: there is no such robot or world.
        DocumentError: a file of the project is wrong.
        GripError: a part of the robot, or a component, can't be started.
    """

    def __init__(
        self,
        source: str | Path,
        robot: RobotKind = "sim",
        *,
        world: str | World | None = None,
        seed: int = 0,
        components: Collection[str] = (),
        pace: float | None = None,
        progress: Progress = silent,
    ):
        with ExitStack() as stack:
            project = _project(source, stack)
            if isinstance(world, World):
                world = str(world.save(_temporary(stack) / "world.yaml"))
            project = in_world(project, world)
            self._catalog = catalogue_of(project)
            seen = [f"sensor/{name}" for name, each in project.file.sensors.items() if each.camera or robot == "ros"]
            needs = ["arm/plan", "hand/open", *seen, *(f"component/{name}" for name in components)]
            refuse(f"starts the component {name}" for name in components if robot != "fake")
            for need in needs[2:]:
                self._catalog.get(need)
            parts = stack.enter_context(open_resources(Opening(project, seed, pace, progress), needs, robot))
            self._context, self.referee = parts.context(), parts.referee
            self._stack = stack.pop_all()
        self.arms, self.hands = tuple(project.file.arms), tuple(project.file.hands)
        self.cameras = tuple(name.partition("/")[2] for name in seen)

    def arm(self, name: str = "") -> Arm:
        """Return an arm; without a name, the only one."""
        return self._context.arm(name)

    def hand(self, name: str = "") -> Hand:
        """Return a hand; without a name, the only one."""
        return self._context.hand(name)

    def camera(self, name: str = "") -> Camera:
        """Return a camera; without a name, the only one."""
        return self._context.camera(name)

    def scene(self) -> Scene:
        """Return what arms avoid."""
        return self._context.scene()

    def do(self, node: str, /, **ports: object) -> Done:
        """Run a node of the catalogue to its end, see docs/nodes.md; whatever interrupts this stops it first.

        Args:
            **ports: its inputs, as values, and its parameters.

        Raises:
            UnknownNameError: there is no such node, or it has no such port; or a value names what isn't there.
            TypeError: a port lacks.
            InvalidTaskError: a parameter isn't of its type.
            NodeFailedError: it failed; the error has `failure` with its code, message and data.
        """
        manifest = self._catalog.get(node)
        known: Mapping[str, InputPort | Parameter] = {**manifest.parameters, **manifest.inputs}
        for name in ports:
            if name not in known:
                raise UnknownNameError("port", name, known, node)
        if missing := [f"{name} ({port.type})" for name, port in known.items() if port.required and name not in ports]:
            raise TypeError(f"{node} needs {', '.join(missing)}")
        values = {f"in {name}": value for name, value in ports.items() if _is_input(manifest, name, value)}
        types = {f"in {name}": port.type for name, port in manifest.inputs.items() if f"in {name}" in values}
        said = {
            "node": node,
            "with": {name: value for name, value in ports.items() if f"in {name}" not in values},
            "in": {name.removeprefix("in "): name for name in values},
            "out": {name: f"out {name}" for name in manifest.outputs},
        }
        types |= {f"out {name}": port.type for name, port in manifest.outputs.items()}
        with TreeRun(self._context, self._catalog) as run:
            state = BehaviourTree.of_node(said, run, variables=types, outcomes=manifest.outcomes, place=node)
            data = dict(values)
            try:
                outcome = state.execute(data)
            except NodeError as error:
                raise error.cause if isinstance(error.cause, GripError) else error from None
            assert state.compiled is not None, "of a task"
            if manifest.outcomes[outcome] == "failure":
                raise NodeFailedError(node, outcome, state.compiled.end().failure)
            return Done(node, outcome, {name: data.get(f"out {name}") for name in manifest.outputs})

    def close(self) -> None:
        """Stop everything that was started."""
        self._stack.close()


def _is_input(manifest: Manifest, name: str, value: object) -> bool:
    """Tell whether a port is given as an input; some are a parameter as well, and then literals are that."""
    return name in manifest.inputs and not (name in manifest.parameters and isinstance(value, str | int | float))


def _project(source: str | Path, stack: ExitStack) -> Project:
    if str(source) not in ROBOTS:
        return find_project(source)
    folder = _temporary(stack)
    made = new_robot(str(source), folder, lambda question, names: names[0])
    (folder / FILE_NAME).write_text(made.files[FILE_NAME], encoding="utf-8")
    return in_world(find_project(folder), "table")


def _temporary(stack: ExitStack) -> Path:
    return Path(stack.enter_context(TemporaryDirectory(prefix="grip_")))
