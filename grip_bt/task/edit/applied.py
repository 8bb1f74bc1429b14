"""Commands applied to tasks: pure, with an exact inverse."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from grip_bt.base.errors import EditError

from ..model import Task
from . import commands as c
from .commenting import comment
from .editing import Editing
from .fields import bind, connect, disconnect, set_key, set_meaning, unbind, unset_key
from .kinds import change_kind
from .nodes import add, move, remove, rename
from .outcomes import rename_outcome
from .pasting import paste
from .steps import Step, path_after
from .titles import title_of
from .unwrapping import unwrap
from .variables import declare, rename_variable, undeclare
from .wrapping import wrap


def _needs_a_catalogue(editing: Editing, command: c.Convert | c.Extract | c.Inline) -> None:
    """Refuse a command as it is: this room knows no nodes."""
    name = "extracted" if isinstance(command, c.Extract) else "expanded"
    what = "a conversion takes" if isinstance(command, c.Convert) else f"{command.do} takes"
    message = f"{what} a catalogue: apply what `grip_bt.compilers.restructure.{name}` returns for it"
    raise EditError(command.path, message)


_PLANS: dict[type[Any], Callable[[Editing, Any], None]] = {
    c.Add: add,
    c.Paste: paste,
    c.Remove: remove,
    c.Move: move,
    c.Rename: rename,
    c.Set: set_key,
    c.Unset: unset_key,
    c.Comment: comment,
    c.Connect: connect,
    c.Disconnect: disconnect,
    c.Wrap: wrap,
    c.Unwrap: unwrap,
    c.ChangeKind: change_kind,
    c.Convert: _needs_a_catalogue,
    c.Extract: _needs_a_catalogue,
    c.Inline: _needs_a_catalogue,
    c.Bind: bind,
    c.Unbind: unbind,
    c.SetMeaning: set_meaning,
    c.Declare: declare,
    c.Undeclare: undeclare,
    c.RenameVariable: rename_variable,
    c.RenameOutcome: rename_outcome,
}


@dataclass(frozen=True)
class Applied:
    """A task after a command.

    Attributes:
        task: the new task.
        inverse: the command that leads back.
        steps: what was done, for whatever else follows the edit.
    """

    task: Task
    inverse: c.Patch
    steps: tuple[Step, ...]

    def path(self, before: str) -> str | None:
        """Return where the node that was at a path is now; None when it is gone."""
        return path_after(before, self.steps)


def apply(task: Task, command: c.AnyCommand) -> Applied:
    """Return the task after a command, and the inverse: `apply(applied.task, applied.inverse).task == task`.

    Raises:
        EditError: the command can't be carried out; nothing has changed.
    """
    return _apply(task, command, title_of(command))


def _apply(task: Task, command: c.AnyCommand, title: str) -> Applied:
    if isinstance(command, c.Group):
        steps: tuple[Step, ...] = ()
        back: tuple[Step, ...] = ()
        for part in command.commands:
            done = _apply(task, part, title)
            task, steps, back = done.task, steps + done.steps, done.inverse.steps + back
        return Applied(task, c.Patch(title=title, steps=back), steps)
    editing = Editing(task)
    if isinstance(command, c.Patch):
        for step in command.steps:
            editing.take(step)
    else:
        _PLANS[type(command)](editing, command)
    made = editing.draft.task(_about(command)) if editing.steps else task
    return Applied(made, c.Patch(title=title, steps=tuple(editing.back)), tuple(editing.steps))


def _about(command: Any) -> str:
    return str(getattr(command, "path", "") or getattr(command, "parent", "") or (getattr(command, "paths", ("",))[0]))
