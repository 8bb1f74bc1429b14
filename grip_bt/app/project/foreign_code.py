"""Code that isn't GRIP's: what a run would import or start of it, and the refusal of `--no-code`."""

from __future__ import annotations

import os
import shlex
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path

from grip_bt.app.project.folder import Project
from grip_bt.base.errors import GripError, UntrustedCodeError
from grip_bt.compilers.resolve import resolve
from grip_bt.task import Task
from grip_bt.task.catalog import Catalog
from grip_bt.task.catalog.component_file import load_component
from grip_bt.task.model import Foreign

VARIABLE = "GRIP_NO_CODE"
"""Set in a process, and so in those that it starts, where nobody's code but GRIP's may run."""
_OURS = ("grip_bt", "grip_sim", "py_trees")


def forbid() -> None:
    """Let nobody's code but GRIP's run, in this process and in those that it starts."""
    os.environ[VARIABLE] = "1"


def refuse(found: Iterable[str]) -> None:
    """Raise UntrustedCodeError, which names all, where code that isn't GRIP's is forbidden and some would run."""
    if os.environ.get(VARIABLE) and (told := list(dict.fromkeys(found))):
        raise UntrustedCodeError(told)


def of_task(project: Project, task: Task, catalog: Catalog, robot: str, mocked: Collection[str] = ()) -> Iterator[str]:
    """Yield what a run of a valid task would import or start that isn't GRIP's; `mocked` nodes play scripts."""
    components = {}
    for part in resolve(task, catalog).root.walk():
        if isinstance(part.node, Foreign):
            if catalog.code.is_third_party(part.node.imported):
                yield f"{part.path}: imports {part.node.imported}"
        elif (face := part.manifest) is not None and face.implementation and not {part.path, face.id} & {*mocked}:
            where = face.implementation.rpartition(":")[0]
            if where.endswith(".py") or where.partition(".")[0] not in _OURS:
                yield f"{part.path}: imports {where}"
            if face.id.startswith("component/"):
                components[face.id.partition("/")[2]] = part.path
    for name in components if robot != "fake" else ():
        yield from of_component(project.component_folders().get(name))


def of_component(folder: Path | None) -> Iterator[str]:
    """Yield what the server of a component would start; nothing where it has none of its own."""
    try:
        component = None if folder is None else load_component(folder)
    except GripError:
        return  # refused in its own words when it is started
    if component is not None and (start := component.start) is not None:
        words = start.command or filter(None, (start.package, start.executable or start.launch))
        yield f"component {component.name}: starts {shlex.join(words)}"
