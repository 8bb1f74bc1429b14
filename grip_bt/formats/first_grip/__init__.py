"""Tasks and configurations of the first GRIP -> a project: read as data; nothing that is in them is run."""

from __future__ import annotations

from grip_bt.formats.imported import Imported, Request

from .importer import import_grip

__all__ = ["import_grip", "read"]


def read(request: Request) -> Imported:
    """Return the tasks and the files of a project that a file or a folder becomes.

    Raises:
        GripError: it can't be read, a task is broken, or there is nothing of the first GRIP in it.
    """
    return import_grip(request.path)
