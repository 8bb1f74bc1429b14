"""Legacy SMACH files -> tasks: a static reading that runs nothing, and a recorded execution for what it can't see."""

from __future__ import annotations

from pathlib import Path

from grip_bt.base.errors import GripError
from grip_bt.base.issue import Issue
from grip_bt.formats.imported import CODES, Imported, Item, Request
from grip_bt.task import Task

from .importer import ImportedFile, advice, import_file, write_import
from .objects import FromMachine, from_machine
from .reader.found import Span
from .recorded import import_with_execution

__all__ = [
    "FromMachine",
    "ImportedFile",
    "Span",
    "advice",
    "from_machine",
    "import_file",
    "import_with_execution",
    "read",
    "write_import",
]


def read(request: Request) -> Imported:
    """Return the tasks of a legacy file, or of all Python files of a folder, with their leaves.

    Raises:
        GripError: the file can't be read, or there is no machine in it, or not the one that is wanted.
    """
    path = request.path
    if not path.exists():
        raise GripError(f"{path}: there is no such file or folder")
    root = path if path.is_dir() else None
    if request.execute:
        read = [import_with_execution(file, root, request.arguments) for file in _files(path)]
    else:
        read = [import_file(file, root) for file in _files(path)]
    if len(read) == 1 and read[0].error:
        raise GripError(read[0].error)
    if not any(each.containers or each.error for each in read):
        raise GripError(f"{path}: no SMACH machine was found")
    names = [name for each in read for name in each.tasks]
    if request.select and request.select not in names:
        there = ", ".join(names) or "none"
        raise GripError(f"no machine {request.select!r} was imported (available: {there})")
    tasks: dict[str, Task] = {}
    files: dict[str, str] = {}
    items, errors, said = [], [], []
    for each in read:
        mine = {name: task for name, task in each.tasks.items() if request.select in ("", name)}
        stem = each.file.stem
        tasks |= {name if name == stem else f"{stem}_{name}": task for name, task in mine.items()}
        if mine and each.leaves is not None:
            folder = f"smach_{each.leaves.stem}"
            texts = each.leaves.texts(request.nodes / folder)
            files |= {f"nodes/{folder}/{name}": text for name, text in texts.items()}
        source = f"{each.file.name} (Python 2)" if each.converted else each.file.name
        items += [Item(found.title, source, found.span.line, tuple(found.issues)) for found in each.containers]
        if each.error:
            errors.append(Issue(each.file.name, "unreadable", CODES["unreadable"], each.error))
        if each.containers:
            said += advice(each, request.execute, request.arguments)
    return Imported(tasks, tuple(errors), tuple(items), files=files, advice=tuple(said))


def _files(path: Path) -> list[Path]:
    if path.is_dir():
        return sorted(p for p in path.rglob("*.py") if not any(part.startswith(".") for part in p.parts))
    return [path]
