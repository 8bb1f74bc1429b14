"""py_trees, in and out: objects of a tree, and its XML; what has no exact equivalent is refused by name and place."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryFile

from grip_bt.base.errors import GripError
from grip_bt.base.interpreter import python_command
from grip_bt.base.issue import Issue
from grip_bt.base.yaml.tree import read_file
from grip_bt.formats.imported import Imported, ImportRefusedError, Request
from grip_bt.nodes.tree_code import is_tree_code
from grip_bt.task import Task

from .tree import to_task
from .xml import from_xml, to_xml

__all__ = ["from_xml", "import_from_code", "read", "to_task", "to_xml"]

TIMEOUT = 60.0
"""How long [s] somebody's code may take."""


def read(request: Request) -> Imported:
    """Return the task of an XML file, or of the tree that somebody's code builds.

    Raises:
        GripError: it can't be read or has no equivalent, or its code has to be run and nobody has said so.
    """
    where = str(request.path)
    if is_tree_code(where):
        if not request.execute:
            raise GripError(f"{where}: this runs the code that builds the tree; if you trust it, say so with --execute")
        return import_from_code(where, Path.cwd())
    return from_xml(read_file(request.path), request.catalog(), where, request.path.parent)


def import_from_code(where: str, folder: Path, timeout: float = TIMEOUT, *, as_it_is: bool = False) -> Imported:
    """Run somebody's code in a process of its own and return the task of the tree that it makes.

    Args:
        where: as `grip run` takes it; see `grip_bt.nodes.tree_code.place_of`.
        folder: where modules are looked for last, such as the current folder.
        timeout: how long [s] the code may take.
        as_it_is: for a drawing of the tree, node by node.

    Raises:
        ImportRefusedError: behaviours of the tree have no equivalent in a task.
        GripError: the code can't be imported, fails, takes too long, or gives something else than a tree.
    """
    command = python_command("-m", f"{__name__}.executed", where, *(["as_it_is"] if as_it_is else []))
    paths = os.pathsep.join([*filter(None, sys.path), str(folder.resolve())])
    files = TemporaryFile("w+", errors="replace"), TemporaryFile("w+", errors="replace")
    with files[0] as output, files[1] as words:  # no pipes, which what the code has started may keep open
        try:
            done = subprocess.run(
                command,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=words,
                timeout=timeout,
                env={**os.environ, "PYTHONPATH": paths},
            )
        except subprocess.TimeoutExpired:
            why = f"no tree was built in {timeout:g} s; give a factory that only builds"
            raise GripError(f"{where}: {why}") from None
        output.seek(0)
        words.seek(0)
        said = [line for line in output if line.startswith("{")]
        last = words.read().strip().splitlines()[-1:] or ["it said nothing"]
    if not said:
        raise GripError(f"{where}: its process ended with status {done.returncode}: {last[0]}")
    told = json.loads(said[-1])
    if "error" in told:
        raise GripError(f"{where}: {told['error']}")
    if "refused" in told:
        raise ImportRefusedError(where, [Issue(**issue) for issue in told["refused"]])
    task = Task.model_validate(told["task"])
    return Imported({task.name: task}, tuple(Issue(**issue) for issue in told["issues"]))
