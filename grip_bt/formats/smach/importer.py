"""Importing a file: what is in it, the tasks that it becomes, the files that hold them, and what is left to do."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from grip_bt.base.errors import DocumentError
from grip_bt.formats.imported import write_generated
from grip_bt.formats.names import free
from grip_bt.nodes.smach_leaf import task_name
from grip_bt.task import Task, dumps

from .leaves import MARK, Leaves
from .reader.found import ContainerInfo, Span
from .reader.interpreter import Interpreter
from .reader.names import Project
from .to_task import TaskMaker

_AT_RUN_TIME = "known only at run time"


@dataclass
class ImportedFile:
    """What became of a legacy file.

    Attributes:
        containers: every container that it makes, in the order of the text.
        tasks: name -> task, one for each outermost container that was imported.
        converted: whether the file was Python 2.
        error: why it couldn't be read at all.
    """

    file: Path
    containers: list[ContainerInfo] = field(default_factory=list)
    tasks: dict[str, Task] = field(default_factory=dict)
    leaves: Leaves | None = None
    converted: bool = False
    error: str = ""

    def verdicts(self) -> dict[str, int]:
        """Return how many containers were imported how well."""
        found = [c.verdict for c in self.containers]
        return {verdict: found.count(verdict) for verdict in ("exact", "partial", "failed")}


def import_file(
    file: Path,
    root: Path | None = None,
    run: Callable[[list[ContainerInfo], Path, Path], list[ContainerInfo]] | None = None,
) -> ImportedFile:
    """Read a legacy file.

    Args:
        file: the file.
        root: the folder in which the modules that it imports are looked for; its own by default.
        run: runs it, and adds to the containers that were read what it saw; without it nothing is run.
    """
    file, folder = file.resolve(), (root or file.parent).resolve()
    project, result = Project(folder), ImportedFile(file)
    try:
        source = project.source(file)
    except DocumentError as error:
        result.error = str(error)
        return result
    result.converted = source.converted
    if run is None and not any(isinstance(node, (ast.Import, ast.ImportFrom)) for node in ast.walk(source.tree)):
        return result  # nothing in it can be smach's
    reader = Interpreter(project)
    reader.main_file(file)
    found = _distinct(reader.containers, file)
    if run is not None:
        if not found and "smach" not in source.text:
            return result  # nothing to see, so nothing is run
        found = run(found, file, folder)
    return _make_tasks(result, found)


def _make_tasks(result: ImportedFile, found: list[ContainerInfo]) -> ImportedFile:
    """Make a task of each outermost container."""
    result.leaves = Leaves(result.file)
    result.containers = found
    for container in found:
        if container.parent is None:
            executed = container.attributes.get("<executed>")
            if isinstance(executed, Span):
                text = "importing the module runs the machine: put that under `if __name__ == '__main__'`"
                container.problem("partial", text, executed)
            name = _name(container, result)
            before = dict(result.leaves.specs)
            task = TaskMaker(container, name, result.leaves).make()
            if task is None:
                result.leaves.specs = before
            else:
                result.tasks[name] = task
    return result


def _distinct(containers: list[ContainerInfo], file: Path) -> list[ContainerInfo]:
    """Return the containers of a file, one for each place and each machine that holds it."""
    mine = [c for c in containers if c.outermost.span.file == file]
    seen: dict[tuple[int, int, int | None], ContainerInfo] = {}
    for container in mine:
        key = (container.span.line, container.span.column, id(container.parent) if container.parent else None)
        seen.setdefault(key, container)
    # What a class or function makes again for nobody is no second machine.
    nested = {(c.span.line, c.span.column) for c in seen.values() if c.parent is not None}
    kept = [c for c in seen.values() if c.parent is not None or (c.span.line, c.span.column) not in nested]
    return sorted(kept, key=lambda c: (c.span.line, c.span.column))


def _name(container: ContainerInfo, result: ImportedFile) -> str:
    entry = container.entry
    wanted = entry.attr if isinstance(entry, ast.Attribute) else ""
    if not wanted:
        wanted = container.cls if container.cls != container.kind else result.file.stem
    return free(task_name(wanted), result.tasks)


def write_import(imported: ImportedFile, tasks: Mapping[str, Path], nodes: Path) -> list[Path]:
    """Write tasks and their leaves; return the files.

    Args:
        imported: what was read.
        tasks: the file of each task, by name.
        nodes: the project's folder of nodes.

    Raises:
        GripError: a file is in the way that wasn't generated; nothing was written.
    """
    assert imported.leaves is not None, "a file with tasks has leaves"
    folder = nodes / f"smach_{imported.leaves.stem}"
    header = f"# {MARK} from {imported.file.name}.\n"
    texts = {path: header + dumps(imported.tasks[name]) for name, path in tasks.items()}
    texts |= {folder / name: text for name, text in imported.leaves.texts(folder).items()}
    return write_generated(texts, "smach")


def advice(
    imported: ImportedFile, executed: bool, given: Mapping[str, Mapping[str, object]] | None = None
) -> list[str]:
    """Return what to do, in lines; none where everything is exact. `given`: the arguments that it was run with."""
    open_ = [c for c in imported.containers if c.verdict != "exact"]
    unknown = [c for c in open_ if any(_AT_RUN_TIME in issue.message for issue in c.issues)]
    lines = []
    if unknown and not executed:
        lines.append(
            "some values are known only at run time; if you trust the file, import it again with --execute,"
            " which runs it"
        )
    needs = _arguments(imported, unknown, given or {})
    for name, parameters in needs.items():
        said = ", ".join(f"{parameter}: ..." for parameter in parameters)
        how = "" if executed else "--execute and "
        lines.append(f"what {name} is given: {how}--arguments FILE.yaml with `{name}: {{{said}}}`")
    if executed and any(c.verdict == "failed" for c in unknown) and not needs:
        lines.append(
            "what it takes from its surroundings: write a function without arguments that builds the machine, and use"
            " grip_bt.from_machine(build(), source=build)"
        )
    return lines


def _arguments(
    imported: ImportedFile, unknown: list[ContainerInfo], given: Mapping[str, Mapping[str, object]]
) -> dict[str, list[str]]:
    """Return class or function around a container -> parameters that have no default and weren't given."""
    tree = Project(imported.file.parent).source(imported.file).tree
    found: dict[str, list[str]] = {}
    for container in unknown:
        for node in tree.body:
            inside = node.lineno <= container.span.line <= (node.end_lineno or node.lineno)
            own = isinstance(node, ast.ClassDef) and node.name == container.cls
            if isinstance(node, ast.ClassDef | ast.FunctionDef) and (own or inside):
                missing = [p for p in _required(node) if p not in given.get(node.name, {})]
                if missing:
                    found[node.name] = missing
    return found


def _required(node: ast.ClassDef | ast.FunctionDef) -> list[str]:
    if isinstance(node, ast.ClassDef):
        made = next((n for n in node.body if isinstance(n, ast.FunctionDef) and n.name == "__init__"), None)
        return _required(made)[1:] if made is not None else []
    arguments = node.args.posonlyargs + node.args.args
    required = arguments[: len(arguments) - len(node.args.defaults)]
    return [a.arg for a in required] + [
        a.arg for a, default in zip(node.args.kwonlyargs, node.args.kw_defaults, strict=True) if default is None
    ]
