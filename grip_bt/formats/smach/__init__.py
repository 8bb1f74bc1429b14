"""Legacy SMACH files -> tasks: their construction is recorded, or their text shown as a preview, which runs nothing."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path

from grip_bt.base.errors import GripError
from grip_bt.base.issue import Issue
from grip_bt.formats.imported import CODES, Imported, Item, Request
from grip_bt.task import Task

from .found import Span
from .importer import ImportedFile, advice, import_file, write_import
from .objects import FromMachine, from_machine
from .recorded import Recorder

__all__ = [
    "FromMachine",
    "ImportedFile",
    "Recorder",
    "Span",
    "advice",
    "from_machine",
    "import_file",
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
    read = _read_all(_files(path), request)
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
    items, errors = [], []
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
    return Imported(tasks, tuple(errors), tuple(items), files=files, advice=tuple(advice(read, request.execute)))


def _read_all(files: list[Path], request: Request) -> list[ImportedFile]:
    root = request.path if request.path.is_dir() else None
    with Recorder() if request.execute else nullcontext() as recorder:
        read = []
        for number, file in enumerate(files):
            request.progress(number, len(files), file.name)
            read.append(import_file(file, root, recorder, request.arguments, request.success))
        request.progress(len(files), len(files), "")
    return read


def _files(path: Path) -> list[Path]:
    if path.is_dir():
        return sorted(p for p in path.rglob("*.py") if not any(part.startswith(".") for part in p.parts))
    return [path]
