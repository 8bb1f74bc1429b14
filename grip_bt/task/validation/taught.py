"""Names that tasks teach to arms and hands while they run: of this task, of files that it runs, of others."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from grip_bt.base.errors import SubtaskError, listing
from grip_bt.task import Leaf, Subtask, Task, walk
from grip_bt.task.catalog.project_parts import Problem, ProjectParts

from .analysis import TaskAnalysis

_TEACHERS = {"arm/teach": "arm", "hand/teach": "hand"}
"""Nodes by which a task gives names, and to what."""
_NOT_YET = "not-taught-yet"
BY_TAUGHT, BY_STATE = "go there by `arm/move_to_taught`", "go there by `arm/move_to`"


@dataclass(frozen=True, slots=True)
class _TaughtName:
    """One name that a task gives.

    Attributes:
        side: `arm` or `hand`.
        part: which arm or hand, as the task names it; empty for the only one.
        name: what is taught.
        pose: whether it is a pose of the hand, and no joint state.
    """

    side: str
    part: str
    name: str
    pose: bool


class TaughtNames:
    """What tasks of a project teach.

    Args:
        analysis: of a task.
        parts: of its project.
    """

    def __init__(self, analysis: TaskAnalysis, parts: ProjectParts):
        self._analysis, self._files, self._parts = analysis, analysis.catalog.tasks, parts

    def problem(self, kind: str, part: str, name: str, taught: Collection[str]) -> Problem | None | Literal[False]:
        """Return what is to be said of a name that isn't there yet.

        Args:
            kind: `state` (looked up before a run), `posture` or `taught` (looked up when they are reached).
            part: the arm or the hand.
            name: the name.
            taught: what was taught to it so far, as states or poses.

        Returns:
            What is wrong; None where the task gives the name itself, in time; False where nothing is known of it.
        """
        side = "hand" if kind == "posture" else "arm"
        own = [taught_name for taught_name in self._own if self._fits(taught_name, side, part, name)]
        if own and kind != "state":
            return None
        if kind == "state" and (name in taught or (own and all(taught_name.pose for taught_name in own))):
            return Problem("unknown-state", f"{name!r} is taught as a pose, and is no named state", BY_TAUGHT)
        if own:
            said = f"{name!r} is taught only while this task runs, and named states are looked up before it begins"
            return Problem(_NOT_YET, said, f"{BY_TAUGHT}, or teach it by another task first")
        return self._elsewhere(kind, side, part, name)

    def _elsewhere(self, kind: str, side: str, part: str, name: str) -> Problem | Literal[False]:
        """Return which other tasks of the project give a name; False where none does."""
        found = {
            file: taught_name.pose
            for file, taught_names in self._others.items()
            for taught_name in taught_names
            if self._fits(taught_name, side, part, name)
        }
        files = [file for file, pose in found.items() if not (pose and kind == "state")]
        if files:
            verb = "teaches" if len(files) == 1 else "teach"
            said = f"{name!r} hasn't been taught to {part} yet; {listing(files)} {verb} it"
            return Problem(_NOT_YET, said, f"run {files[0]} first")
        if found:
            said = f"{name!r} is taught as a pose, by {listing(found)}, and is no named state"
            return Problem("unknown-state", said, BY_TAUGHT)
        return False

    def _fits(self, taught_name: _TaughtName, side: str, part: str, name: str) -> bool:
        parts = (self._parts.hands if side == "hand" else self._parts.arms) or {}
        return (taught_name.side, taught_name.name) == (side, name) and only_if_empty(taught_name.part, parts) == part

    @cached_property
    def _own(self) -> list[_TaughtName]:
        """Those of the task, and of the files that it runs, directly or not."""
        found, seen, tasks = list[_TaughtName](), set[str](), [self._analysis.task]
        while tasks:
            task = tasks.pop()
            found += _taught_in(task)
            for _, node in walk(task.root):
                if isinstance(node, Subtask) and node.task not in seen:
                    seen.add(node.task)
                    tasks += self._read(node.task)
        return found

    @cached_property
    def _others(self) -> dict[str, list[_TaughtName]]:
        """Those of each other file of the project that has some."""
        files = self._files.mentioning("/teach")
        return {file: [each for task in self._read(file) for each in _taught_in(task)] for file in files}

    def _read(self, file: str) -> list[Task]:
        try:
            return [self._files.read(file)]
        except SubtaskError:
            return []  # no task, or one that its own check tells about


def only_if_empty(name: object, parts: Collection[str]) -> str:
    """Return the arm or hand that a name means: an empty one means the only one; none of several is empty."""
    return next(iter(parts)) if name == "" and len(parts) == 1 else str(name)


def _taught_in(task: Task) -> Iterator[_TaughtName]:
    for leaf in (node for _, node in walk(task.root) if isinstance(node, Leaf)):
        side, name = _TEACHERS.get(leaf.node), leaf.with_.get("name")
        if side is not None and isinstance(name, str):
            yield _TaughtName(side, str(leaf.with_.get(side, "")), name, leaf.with_.get("pose") is True)
