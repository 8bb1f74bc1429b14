"""What every command is: a value with what it does to a task, and what it is called in a history.

Paths are those of nodes (`attempt/grasp`, the root is `/`); where a command may speak about the task itself, its path
is empty. Keys are those of the file (`with`, `in`, `as`).
"""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

from .editing import Editing


class BaseCommand(BaseModel):
    """An edit of a task, as a value: the same in Python, on the wire and in a history."""

    # built on first use: whoever only runs tasks needs none of it
    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    def in_words(self) -> str:
        """Return the command in a few words, such as `rename look to see`."""
        raise NotImplementedError

    def plan(self, editing: Editing) -> None:
        """Take the steps of which the command consists.

        Raises:
            EditError: it can't be carried out.
        """
        raise NotImplementedError


def said(path: str) -> str:
    """Return a node's path as titles say it."""
    return {"": "the task", "/": "the root"}.get(path, path)


def kind_in_words(kind: str) -> str:
    """Return a kind with its article, such as `a state machine`."""
    words = kind.replace("_", " ")
    return f"an {words}" if words[:1] in "aeiou" else f"a {words}"
