"""py_trees, in and out: objects of a tree, and its XML; what has no exact equivalent is refused by name and place."""

from __future__ import annotations

import ctypes
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

from grip_bt.base.errors import GripError
from grip_bt.base.interpreter import python_command
from grip_bt.base.issue import Issue
from grip_bt.base.yaml.tree import read_file
from grip_bt.formats.imported import Imported, ImportRefusedError, Issues, Request
from grip_bt.formats.pytrees.tree import drawn, to_task
from grip_bt.formats.pytrees.xml import from_xml, to_xml
from grip_bt.nodes.dry_run import dry_run_of_tree
from grip_bt.nodes.tree_code import find_tree, is_tree_code, place_of
from grip_bt.task import Task

__all__ = ["from_xml", "import_from_code", "read", "to_task", "to_xml"]

_PR_SET_PDEATHSIG = 1
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
        return import_from_code(where, Path.cwd(), stand_ins=request.stand_ins)
    return from_xml(read_file(request.path), request.catalog(), where, request.path.parent)


def import_from_code(where: str, folder: Path, *, as_it_is: bool = False, stand_ins: bool = False) -> Imported:
    """Run somebody's code in a process of its own and return the task of the tree that it makes.

    Args:
        where: as `grip run` takes it; see `grip_bt.nodes.tree_code.place_of`.
        folder: where modules are looked for last, such as the current folder.
        as_it_is: for a drawing of the tree, node by node.
        stand_ins: whether packages that are missing are stood in for.

    Raises:
        ImportRefusedError: behaviours of the tree have no equivalent in a task.
        GripError: the code can't be imported, fails, takes too long, or gives something else than a tree.
    """
    how = [word for word, said in (("as_it_is", as_it_is), ("stand_ins", stand_ins)) if said]
    command = python_command("-c", f"from {__name__} import _tell; _tell()", where, *how)
    paths = os.pathsep.join([*filter(None, sys.path), str(folder.resolve())])
    files = TemporaryFile("w+", errors="replace"), TemporaryFile("w+", errors="replace")
    with files[0] as output, files[1] as words:  # no pipes, which what the code has started may keep open
        try:
            done = subprocess.run(
                command,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=words,
                timeout=TIMEOUT,
                env={**os.environ, "PYTHONPATH": paths},
            )
        except subprocess.TimeoutExpired:
            why = f"no tree was built in {TIMEOUT:g} s; give a factory that only builds"
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


def told(where: str, *how: str) -> dict[str, Any]:
    """Return what the tree that code makes is, as the process that runs the code tells it in JSON."""
    missing = Issues()
    try:
        place = place_of(where)
        say: Callable[[str], object] = partial(missing.add, "stood-in", "/")
        with dry_run_of_tree(say, place.file) if "stand_ins" in how else nullcontext():
            root = find_tree(place).tree.root
            if "as_it_is" in how:
                return {"task": _plain(drawn(root, where)[0]), "issues": []}
            made = to_task(root, built_by="" if place.arguments else f"{place.import_name}:{place.name}")
    except ImportRefusedError as error:
        return {"refused": [issue.as_dict() for issue in error.issues]}
    except GripError as error:
        return {"error": str(error)}
    return {"task": _plain(made.task), "issues": [issue.as_dict() for issue in (*missing, *made.issues)]}


def _plain(task: Task) -> dict[str, Any]:
    return task.model_dump(by_alias=True, exclude_unset=True, mode="json")


def _tell() -> None:
    """Tell what somebody's code builds, and end; what the code itself prints goes to stderr."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)  # when who waits for it is killed, nobody ends it else
    stdout, sys.stdout = sys.stdout, sys.stderr
    answer = json.dumps(told(*sys.argv[1:]))
    sys.stderr.flush()
    stdout.write(answer + "\n")
    stdout.flush()
    os._exit(0)  # what the code left running doesn't keep us
