"""All commands, as one type that is read from JSON, and applied to tasks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Annotated, Literal

from pydantic import Discriminator, TypeAdapter, ValidationError

from grip_bt.base.errors import EditError

from ..model import Task
from .change_kind import ChangeKind, Convert, Extract
from .comment import Comment
from .containers import Unwrap, Wrap
from .editing import BaseCommand, Edit
from .keys import Connect, Disconnect, Set, SetMeaning, Unset
from .nodes import Add, Move, Remove, Rename
from .outcomes import RenameOutcome
from .paste import Paste
from .steps import Step
from .variables import Declare, RenameVariable, Undeclare

LONGEST = 80
"""Characters of a title; longer ones are cut."""


class Group(BaseCommand):
    """Several commands, one gesture: all of them or none."""

    do: Literal["group"] = "group"
    title: str = ""
    commands: tuple[Annotated[AnyCommand, Discriminator("do")], ...]

    def in_words(self) -> str:
        if self.title or not self.commands:
            return self.title or "change nothing"
        first, more = title_of(self.commands[0]), len(self.commands) - 1
        return f"{first} and {more} more" if more else first


class Patch(BaseCommand):
    """An edit in steps: what a conversion, or a text that a person has typed, comes to."""

    do: Literal["patch"] = "patch"
    title: str = ""
    steps: tuple[Step, ...]
    text: str | None = None
    """The whole text that the steps lead to, where somebody has written it."""

    def in_words(self) -> str:
        return self.title or "change several things"

    def plan(self, edit: Edit) -> None:
        for step in self.steps:
            edit.take(step)


AnyCommand = (
    Add | Paste | Remove | Move | Rename | Set | Unset | Comment | Connect | Disconnect | Wrap | Unwrap | ChangeKind
    | Convert | Extract | SetMeaning | Declare | Undeclare | RenameVariable | RenameOutcome
    | Group | Patch
)  # fmt: skip
Command = Annotated[AnyCommand, Discriminator("do")]


_adapter = cache(lambda: TypeAdapter[AnyCommand](Command))


def command_of(data: object) -> AnyCommand:
    """Return the command that JSON-like data describes. Raises EditError: it describes none."""
    try:
        return _adapter().validate_python(data)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        why = f"{'.'.join(map(str, first['loc']))}: {first['msg']}"
    except RecursionError:
        why = "nested too deeply"
    raise EditError("", f"not a command: {why}; docs/editing.md lists them")


def title_of(command: AnyCommand) -> str:
    """Return a command in a few words, such as `rename look to see`."""
    title = " ".join(command.in_words().split())
    return title if len(title) <= LONGEST else f"{title[: LONGEST - 3]}..."


@dataclass(frozen=True)
class Applied:
    """A task after a command, and the steps that led to it."""

    task: Task
    steps: tuple[Step, ...]


def apply(task: Task, command: AnyCommand) -> Applied:
    """Return the task after a command. Raises EditError: the command can't be carried out; nothing has changed."""
    if isinstance(command, Group):
        steps: tuple[Step, ...] = ()
        for part in command.commands:
            done = apply(task, part)
            task, steps = done.task, steps + done.steps
        return Applied(task, steps)
    edit = Edit(task)
    command.plan(edit)
    return Applied(edit.draft.task(_about(command)) if edit.steps else task, tuple(edit.steps))


def _about(command: AnyCommand) -> str:
    return str(getattr(command, "path", "") or getattr(command, "parent", "") or (getattr(command, "paths", ("",))[0]))
