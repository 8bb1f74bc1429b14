"""Legacy SMACH files -> tasks: their construction is recorded, or their text shown as a preview, which runs nothing."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext, suppress
from dataclasses import dataclass, field
from pathlib import Path

from grip_bt.base.errors import DocumentError, GripError
from grip_bt.base.issue import Issue
from grip_bt.commanders.description.packages import package_around
from grip_bt.formats.imported import CODES, Imported, Item, Request
from grip_bt.formats.names import free
from grip_bt.nodes.smach_leaf import task_name
from grip_bt.nodes.smach_source import read_source
from grip_bt.task import Task

from .found import ContainerInfo
from .leaves import Leaves, Meanings
from .objects import FromMachine, from_machine
from .preview import preview
from .recorded import Given, Recorder, recorded_containers
from .to_task import TaskMaker

__all__ = [
    "FromMachine",
    "ImportedFile",
    "Recorder",
    "from_machine",
    "import_file",
    "import_files",
    "make_tasks",
    "read",
]


def read(request: Request) -> Imported:
    """Return the tasks of a legacy file, or of all Python files of a folder, with their leaves.

    Raises:
        GripError: the file can't be read, or there is no machine in it, or not the one that is wanted.
    """
    path = request.path
    if not path.exists():
        raise GripError(f"{path}: there is no such file or folder")
    read, root = list[ImportedFile](), path if path.is_dir() else None
    inside = () if root is None else (file.relative_to(root) for file in sorted(root.rglob("*.py")))
    files_there = [path / p for p in inside if not any(part[0] == "." for part in p.parts)] if root else [path]
    request.progress(0, len(files_there), "")
    around = None if root is None or package_around(root.resolve()) is not None else root  # else it is found
    for imported in import_files(files_there, around, request.execute, request.arguments, request.success):
        read.append(imported)
        request.progress(len(read), len(files_there), imported.file.name)
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
    return Imported(tasks, tuple(errors), tuple(items), files=files, advice=tuple(_advice(read, request.execute)))


def import_files(
    files: list[Path],
    root: Path | None = None,
    execute: bool = False,
    given: Given | None = None,
    success: tuple[str, ...] = (),
) -> Iterator[ImportedFile]:
    """Read legacy files as `import_file` does, several at a time; in their order."""
    with Recorder() if execute else nullcontext() as recorder, ThreadPoolExecutor(6 if execute else 1) as pool:
        yield from pool.map(lambda file: import_file(file, root, recorder, given, success), files)


@dataclass
class ImportedFile:
    """What became of a legacy file.

    Attributes:
        containers: every container that it makes, in the order of the text.
        tasks: name -> task, one for each outermost container that was imported.
    """

    file: Path
    containers: list[ContainerInfo] = field(default_factory=list)
    tasks: dict[str, Task] = field(default_factory=dict)
    leaves: Leaves | None = None
    converted: bool = False
    error: str = ""


def import_file(
    file: Path,
    root: Path | None = None,
    recorder: Recorder | None = None,
    given: Given | None = None,
    success: tuple[str, ...] = (),
) -> ImportedFile:
    """Read a legacy file.

    Args:
        file: the file.
        root: the workspace, in which the modules that it imports are looked for; found around the file by default.
        recorder: runs the construction of its machines, for files that are trusted; without it nothing is run, and what
            the text shows is a preview.
        given: class or function -> parameter -> value, for what has no default; `""` for all.
        success: outcomes that mean success, whatever they are called.
    """
    file, result = file.resolve(), ImportedFile(file.resolve())
    with suppress(OSError):  # which is told of below
        if b"smach" not in file.read_bytes().lower():
            return result  # nothing to see, so nothing is converted or run
    try:
        source = read_source(file)
    except DocumentError as error:
        result.error = str(error)
        return result
    result.converted = source.converted
    if recorder is None:
        found = preview(file)
    else:
        found = recorded_containers(source, recorder.record(file, root and root.resolve(), given))
    return make_tasks(result, found, Meanings(success))


def make_tasks(result: ImportedFile, found: list[ContainerInfo], meanings: Meanings) -> ImportedFile:
    """Make a task of each outermost container."""
    result.leaves, result.containers = Leaves(result.file, meanings), found
    for container in found:
        if container.parent is None and (container.way is not None or container.added):
            name = _name(container, result)
            before = dict(result.leaves.specs)
            task = TaskMaker(container, name, result.leaves).make()
            if task is None:
                result.leaves.specs = before
                continue
            result.tasks[name] = task
    return result


def _name(container: ContainerInfo, result: ImportedFile) -> str:
    builder = container.way.builder.rpartition(".")[2] if container.way is not None else ""
    own = container.cls if container.cls != container.kind else result.file.stem
    return free(task_name(own if builder in ("", "main", "__main__") else builder), result.tasks)


def _advice(files: list[ImportedFile], executed: bool) -> list[str]:
    """Return what to do, each thing once, in lines; none where everything is exact."""
    lines = []
    every = [c for each in files for c in each.containers]
    if not executed and any(c.verdict != "exact" for c in every):
        lines.append(
            "what was read is a preview of the text; if you trust the code, import again with --execute, which runs the"
            " construction of the machines, and none of them"
        )
    needed = {c.way.builder: c.way.missing for c in every if c.way is not None and c.way.missing}
    if executed and needed:
        said = ", ".join(f"{name}: ..." for name in dict.fromkeys(name for names in needed.values() for name in names))
        what = f"{len(needed)} builders need" if len(needed) > 1 else f"{next(iter(needed))} needs"
        lines.append(f"{what} arguments: --arguments FILE.yaml with `{{{said}}}`, or in leaves.py what makes them")
    if executed and any(c.verdict == "failed" for c in every):
        lines.append("what couldn't be built: write a function without arguments that builds it, and import it again")
    return lines
