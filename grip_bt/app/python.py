"""What `import grip_bt as grip` offers for a task beside running it: pictures, checks, trees and machines by hand."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal

from grip_bt.app.building import catalogue_for, project_of
from grip_bt.app.project.foreign_code import of_task, refuse
from grip_bt.app.wiring.open import open_resources
from grip_bt.app.wiring.parts import Opening, RobotKind, silent
from grip_bt.base.files import replace_text
from grip_bt.base.issue import Report
from grip_bt.compilers import CompiledMachine, CompiledTree, to_machine, to_tree
from grip_bt.formats.draw import to_svg
from grip_bt.runtime import RunContext
from grip_bt.runtime.pacing import Pacing
from grip_bt.runtime.ticked import Machine, Tree
from grip_bt.task import Task
from grip_bt.task.validation import validate


@dataclass(frozen=True)
class Picture:
    """A drawing; a notebook shows it."""

    svg: str

    def _repr_svg_(self) -> str:
        return self.svg

    def save(self, path: str | Path) -> None:
        """Write it to a file."""
        replace_text(Path(path), self.svg)


def draw(task: Task, view: Literal["tree", "flow"] = "tree") -> Picture:
    """Return a picture of a task, as a tree or as a flow chart; `print(grip.dumps(task))` is its text."""
    return Picture(to_svg(task, catalogue_for(task), view))


def check(task: Task) -> Report:
    """Return everything that is wrong with a task, by the nodes of its project."""
    return validate(task, catalogue_for(task))


def tree(task: Task, robot: RobotKind = "fake", seed: int = 0, data: dict[str, Any] | None = None) -> Tree:
    """Return a task as a tree of py_trees that is ready to tick; it has the robot until its `shutdown`.

    Args:
        robot: fakes, a simulated robot, or a real one over ROS 2.
        seed: of the simulated world.
        data: initial values for the task's variables.

    Raises:
        InvalidTaskError: the task is wrong.
        GripError: a part of the robot, or a component, can't be started.
    """
    compiled = to_tree(task, catalogue_for(task), data=data)
    return Tree(compiled, _opened(task, compiled, robot, seed)[1], partial(to_svg, task, catalogue_for(task), "tree"))


def machine(task: Task, robot: RobotKind = "fake", seed: int = 0, data: dict[str, Any] | None = None) -> Machine:
    """Return a task as a state machine that is ready to be executed, with a robot, as `tree` does."""
    compiled = to_machine(task, catalogue_for(task), data=data)
    context, close = _opened(task, compiled, robot, seed)
    return Machine(compiled, close, Pacing(context.waker))


def _opened(
    task: Task, compiled: CompiledTree | CompiledMachine, robot: RobotKind, seed: int
) -> tuple[RunContext, Callable[[], None]]:
    project = project_of(task)
    refuse(of_task(project, task, catalogue_for(task), robot))
    leaves = [leaf.manifest for leaf in compiled.leaves.values()]
    needs, own = {each.id for each in leaves}, {each.implementation for each in leaves}
    with ExitStack() as stack:
        parts = stack.enter_context(open_resources(Opening(project, seed, None, silent), needs, robot, own))
        compiled.prepare(context := parts.context())
        stack.callback(compiled.release)
        return context, stack.pop_all().close
