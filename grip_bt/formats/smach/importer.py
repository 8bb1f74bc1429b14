"""Importing a file: what is in it, the tasks that it becomes, the files that hold them, and what is left to do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from grip_bt.base.errors import DocumentError
from grip_bt.formats.imported import write_generated
from grip_bt.formats.names import free
from grip_bt.nodes.smach_leaf import task_name
from grip_bt.nodes.smach_source import read_source
from grip_bt.task import Task, dumps

from .found import ContainerInfo
from .leaves import MARK, Leaves, Meanings
from .preview import preview
from .recorded import Given, Recorder, recorded_containers
from .to_task import TaskMaker


@dataclass
class ImportedFile:
    """What became of a legacy file.

    Attributes:
        containers: every container that it makes, in the order of the text.
        tasks: name -> task, one for each outermost container that was imported.
        needed: function or class -> parameters that nobody has given.
    """

    file: Path
    containers: list[ContainerInfo] = field(default_factory=list)
    tasks: dict[str, Task] = field(default_factory=dict)
    leaves: Leaves | None = None
    converted: bool = False
    error: str = ""
    needed: dict[str, tuple[str, ...]] = field(default_factory=dict)


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
    try:
        source = read_source(file)
    except DocumentError as error:
        result.error = str(error)
        return result
    result.converted = source.converted
    if "smach" not in source.text:
        return result  # nothing to see, so nothing is run
    if recorder is None:
        found = preview(file)
    else:
        found = recorded_containers(file, recorder.record(file, root and root.resolve(), given), given or {})
    return make_tasks(result, found, Meanings(success))


def make_tasks(result: ImportedFile, found: list[ContainerInfo], meanings: Meanings) -> ImportedFile:
    """Make a task of each outermost container."""
    result.leaves, result.containers = Leaves(result.file, meanings), found
    for container in found:
        if container.parent is None and container.way is not None and container.way.missing:
            result.needed[container.way.builder] = container.way.missing
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


def write_import(imported: ImportedFile, tasks: Mapping[str, Path], nodes: Path) -> list[Path]:
    """Write tasks into the files of their names, and their leaves into the project's folder of nodes; return the files.

    Raises:
        GripError: a file is in the way that wasn't generated; nothing was written.
    """
    assert imported.leaves is not None, "a file with tasks has leaves"
    folder = nodes / f"smach_{imported.leaves.stem}"
    header = f"# {MARK} from {imported.file.name}.\n"
    texts = {path: header + dumps(imported.tasks[name]) for name, path in tasks.items()}
    texts |= {folder / name: text for name, text in imported.leaves.texts(folder).items()}
    return write_generated(texts, "smach")


def advice(files: list[ImportedFile], executed: bool) -> list[str]:
    """Return what to do, each thing once, in lines; none where everything is exact."""
    lines = []
    every = [c for each in files for c in each.containers]
    if not executed and any(c.verdict != "exact" for c in every):
        lines.append(
            "what was read is a preview of the text; if you trust the code, import again with --execute, which runs the"
            " construction of the machines, and none of them"
        )
    needed = [(builder, names) for each in files for builder, names in each.needed.items()]
    if executed and needed:
        said = ", ".join(f"{name}: ..." for name in dict.fromkeys(name for _, names in needed for name in names))
        what = f"{len(needed)} builders need" if len(needed) > 1 else f"{needed[0][0]} needs"
        lines.append(f"{what} arguments: --arguments FILE.yaml with `{{{said}}}`, or in leaves.py what makes them")
    if executed and any(c.verdict == "failed" for c in every):
        lines.append(
            "what couldn't be built: write a function without arguments that builds the machine, and use"
            " grip_bt.from_machine(build(), source=build)"
        )
    return lines
