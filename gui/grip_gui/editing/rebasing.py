"""An edit that a page made on an older state, carried over to the present one."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from grip_bt.task.edit import AnyCommand, Group, Patch, command_of, path_after
from grip_bt.task.edit.steps import Step

from .errors import StaleEditError

_ONE = ("path", "parent")
_MANY = ("paths",)


def rebased(command: AnyCommand, since: Iterable[tuple[Step, ...]]) -> AnyCommand:
    """Return a command with the paths of its nodes as they are after some edits.

    Raises:
        StaleEditError: a node that it is about is gone.
    """
    taken = tuple(step for steps in since for step in steps)
    if not taken:
        return command
    if _is_exact(command):
        raise StaleEditError("the task has just been changed elsewhere; look at it, then do this again")
    return command_of(_moved(command.model_dump(mode="json"), taken))


def _is_exact(command: AnyCommand) -> bool:
    """Tell whether a command fits one state of a task alone."""
    if isinstance(command, Group):
        return any(_is_exact(part) for part in command.commands)
    return isinstance(command, Patch)


def _moved(data: Any, steps: tuple[Step, ...]) -> Any:
    if isinstance(data, list):
        return [_moved(part, steps) for part in data]
    if not isinstance(data, dict) or "do" not in data:
        return data
    moved = {key: _where(value, steps) if key in _ONE else value for key, value in data.items()}
    moved |= {key: [_where(path, steps) for path in data[key]] for key in _MANY if key in data}
    if "commands" in data:
        moved["commands"] = _moved(data["commands"], steps)
    return moved


def _where(path: str, steps: tuple[Step, ...]) -> str:
    if path == "":
        return path
    now = path_after(path, steps)
    if now is None:
        raise StaleEditError(f"{path} was removed elsewhere while you were editing it; nothing was changed")
    return now
