"""py_trees, in and out: objects of a tree, and its XML; what has no exact equivalent is refused by name and place."""

from __future__ import annotations

from pathlib import Path

from grip_bt.base.errors import GripError
from grip_bt.base.issue import Issue
from grip_bt.base.yaml.tree import read_file
from grip_bt.formats.child_process import TIMEOUT, last_json
from grip_bt.formats.imported import Imported, ImportRefusedError, Request
from grip_bt.nodes.tree_code import is_tree_code
from grip_bt.task import Task

from .tree import to_task
from .xml import from_xml, to_xml

__all__ = ["from_xml", "import_from_code", "read", "to_task", "to_xml"]


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
    words = [where, "as_it_is"] if as_it_is else [where]
    answer = last_json(f"{__name__}.executed", words, [folder.resolve()], timeout)
    if answer.data is None:
        if answer.status is None:
            raise GripError(f"{where}: no tree was built in {timeout:g} s; give a factory that only builds")
        words = answer.stderr.strip().splitlines()[-1:] or ["it said nothing"]
        raise GripError(f"{where}: its process ended with status {answer.status}: {words[0]}")
    told = answer.data
    if "error" in told:
        raise GripError(f"{where}: {told['error']}")
    if "refused" in told:
        raise ImportRefusedError(where, [Issue(**issue) for issue in told["refused"]])
    task = Task.model_validate(told["task"])
    return Imported({task.name: task}, tuple(Issue(**issue) for issue in told["issues"]))
