"""Names that tasks teach to arms and hands while they run: of this task, of files that it runs, of others."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from grip_bt.base.errors import SubtaskError, listing
from grip_bt.task import Leaf, Subtask, Task, walk
from grip_bt.task.catalog.project_parts import Equipment, Trouble

from .survey import Survey

_TEACHERS = {"arm/teach": "arm", "hand/teach": "hand"}
"""Nodes by which a task gives names, and to what."""
NOT_YET = "not-taught-yet"
BY_TAUGHT, BY_STATE = "go there by `arm/move_to_taught`", "go there by `arm/move_to`"


@dataclass(frozen=True, slots=True)
class Lesson:
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


class Lessons:
    """What tasks of a project teach.

    Args:
        survey: of a task.
        equipment: of its project.
    """

    def __init__(self, survey: Survey, equipment: Equipment):
        self._survey, self._files, self._equipment = survey, survey.catalog.tasks, equipment

    def trouble(self, kind: str, part: str, name: str, taught: Collection[str]) -> Trouble | None | Literal[False]:
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
        own = [lesson for lesson in self._own if self._fits(lesson, side, part, name)]
        if own and kind != "state":
            return None
        if kind == "state" and (name in taught or (own and all(lesson.pose for lesson in own))):
            return Trouble("unknown-state", f"{name!r} is taught as a pose, and is no named state", BY_TAUGHT)
        if own:
            said = f"{name!r} is taught only while this task runs, and named states are looked up before it begins"
            return Trouble(NOT_YET, said, f"{BY_TAUGHT}, or teach it by another task first")
        return self._elsewhere(kind, side, part, name)

    def _elsewhere(self, kind: str, side: str, part: str, name: str) -> Trouble | Literal[False]:
        """Return which other tasks of the project give a name; False where none does."""
        found = {
            file: lesson.pose
            for file, lessons in self._others.items()
            for lesson in lessons
            if self._fits(lesson, side, part, name)
        }
        files = [file for file, pose in found.items() if not (pose and kind == "state")]
        if files:
            verb = "teaches" if len(files) == 1 else "teach"
            said = f"nothing was taught to {part} as {name!r} yet; {listing(files)} {verb} it"
            return Trouble(NOT_YET, said, f"run {files[0]} first")
        if found:
            said = f"{name!r} is taught as a pose, by {listing(found)}, and is no named state"
            return Trouble("unknown-state", said, BY_TAUGHT)
        return False

    def _fits(self, lesson: Lesson, side: str, part: str, name: str) -> bool:
        parts = (self._equipment.hands if side == "hand" else self._equipment.arms) or {}
        return (lesson.side, lesson.name) == (side, name) and only_if_empty(lesson.part, parts) == part

    @cached_property
    def _own(self) -> list[Lesson]:
        """Those of the task, and of the files that it runs, directly or not."""
        found, seen, tasks = list[Lesson](), set[str](), [self._survey.task]
        while tasks:
            for _, node in walk(tasks.pop().root):
                found += _taught_by(node) if isinstance(node, Leaf) else ()
                if isinstance(node, Subtask) and node.task not in seen:
                    seen.add(node.task)
                    tasks += self._read(node.task)
        return found

    @cached_property
    def _others(self) -> dict[str, list[Lesson]]:
        """Those of each other file of the project that has some."""
        files = {file: self._read(file) for file in self._files.mentioning("/teach")}
        leaves = {
            file: [node for task in tasks for _, node in walk(task.root) if isinstance(node, Leaf)]
            for file, tasks in files.items()
        }
        return {file: [lesson for node in nodes for lesson in _taught_by(node)] for file, nodes in leaves.items()}

    def _read(self, file: str) -> list[Task]:
        try:
            return [self._files.read(file)]
        except SubtaskError:
            return []  # no task, or one that its own check tells about


def only_if_empty(name: object, parts: Collection[str]) -> str:
    """Return the arm or hand that a name means: an empty one means the only one; none of several is empty."""
    return next(iter(parts)) if name == "" and len(parts) == 1 else str(name)


def _taught_by(leaf: Leaf) -> Iterator[Lesson]:
    side, name = _TEACHERS.get(leaf.node), leaf.with_.get("name")
    if side is not None and isinstance(name, str):
        yield Lesson(side, str(leaf.with_.get(side, "")), name, leaf.with_.get("pose") is True)
