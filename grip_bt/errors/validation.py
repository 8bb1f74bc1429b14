"""Errors of tasks that were read but are wrong, or have no exact equal in another form."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .base import GripError


class InvalidTaskError(GripError):
    """A task was read but is wrong; `issues` holds everything that was found."""

    def __init__(self, issues: Sequence[Any], source: str = ""):
        self.issues, self.source = tuple(issues), source
        super().__init__("\n".join(str(i) for i in issues))


class NotExpressibleError(GripError):
    """A compiler can't express a node exactly in the target form; it refuses instead of approximating."""

    def __init__(self, path: str, what: str, target: str):
        self.path, self.what, self.target = path, what, target
        super().__init__(f"{path}: {what} can't be expressed exactly as {target}")


class RefusedFileError(GripError):
    """Parts of a file from elsewhere have no exact equal in a task; nothing was made of it.

    Attributes:
        source: the file.
        refused: each of them, with its place, and what to do.
    """

    def __init__(self, source: str, refused: Sequence[Any]):
        self.source, self.refused = source, tuple(refused)
        parts = "part has" if len(self.refused) == 1 else "parts have"
        listed = "".join(f"\n  {refusal}" for refusal in self.refused)
        super().__init__(f"{source or '<text>'}: {len(self.refused)} {parts} no exact equal in a task:{listed}")
