"""What comes out of reading a tree."""

from __future__ import annotations

from dataclasses import dataclass

from grip_bt.base.errors import GripError
from grip_bt.task import model


@dataclass(frozen=True)
class Remark:
    """Something to know about one node.

    Attributes:
        path: the node's path in the task.
        text: what it is.
    """

    path: str
    text: str

    def __str__(self) -> str:
        return f"{self.path}: {self.text}"


@dataclass(frozen=True)
class Imported:
    """A task made of a tree.

    Attributes:
        task: the document.
        names: path in the task -> name of the behaviour, where the task needed another one.
        remarks: what isn't quite what it was, such as the clock of a timeout.
    """

    task: model.Task
    names: dict[str, str]
    remarks: tuple[Remark, ...]


class RefusedTreeError(GripError):
    """Behaviours of a tree have no equal in a task; nothing was made of it.

    Attributes:
        refused: each of them, and why.
    """

    def __init__(self, refused: tuple[Remark, ...]):
        self.refused = refused
        listed = "".join(f"\n  {remark}" for remark in refused)
        super().__init__(f"the tree can't become a task:{listed}")
