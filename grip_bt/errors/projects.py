"""Errors of a project's folder, files and own code."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .base import ExpectedError, GripError


class ProjectExistsError(GripError):
    """A new project was asked for where something is already.

    Attributes:
        folder: the folder, or file, that was named.
    """

    def __init__(self, folder: Any):
        self.folder = str(folder)
        super().__init__(f"{folder} isn't an empty folder; nothing was written. Name a folder that isn't there yet")


class NotWritableError(GripError):
    """A place that has to be written can't be: no permission, a read-only disk, no room.

    Attributes:
        place: the file or folder.
    """

    def __init__(self, place: Any, error: OSError, advice: str):
        self.place = str(place)
        super().__init__(f"{place} can't be written ({error.strerror or error}): {advice}")


class ImplementationError(GripError):
    """A node's code can't be imported; `node` is its id, `implementation` what its manifest names."""

    def __init__(self, node: str, implementation: str, reason: str):
        self.node, self.implementation, self.reason = node, implementation, reason
        super().__init__(f"node {node}: {implementation}: {reason}")


class BadFileError(ExpectedError):
    """A file that a task names can't be read, or isn't what it should be."""

    code = "bad_file"


class StrangeCodeError(GripError):
    """Code that isn't GRIP's would be run, and `--no-code` was said.

    Attributes:
        found: what would be imported or started, each in words.
    """

    def __init__(self, found: Sequence[str]):
        self.found = tuple(found)
        super().__init__(
            "--no-code: this runs code that isn't GRIP's:\n"
            + "".join(f"  {each}\n" for each in self.found)
            + "nothing of it was imported or started; look at it, and leave --no-code out if you trust it"
        )
