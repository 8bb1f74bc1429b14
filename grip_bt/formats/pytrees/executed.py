"""A tree that code of somebody builds -> task: it runs in a process of its own, and only what it built comes back.

That process isn't a sandbox: whoever asks for it trusts the code. It keeps ours clean of whatever the code imports,
starts or leaves behind, and can be stopped.
"""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from grip_bt.base.errors import GripError
from grip_bt.base.interpreter import python_command
from grip_bt.task import model

from .convert import to_task
from .result import Imported, RefusedTreeError, Remark

TIMEOUT = 60.0
"""How long [s] a factory may take to build its tree."""


def import_from_code(where: str, folder: Path, timeout: float = TIMEOUT) -> Imported:
    """Run a factory in a process of its own and return the task of the tree that it builds.

    Args:
        where: `package.module:factory`: a function that is called without arguments, a class, or a tree that is there.
        folder: where modules are looked for last, such as the current folder.
        timeout: how long [s] the code may take.

    Raises:
        RefusedTreeError: behaviours of the tree have no equal in a task.
        GripError: the code can't be imported, fails, takes too long, or gives something else than a tree.
    """
    paths = os.pathsep.join(filter(None, sys.path))
    command = python_command("-m", __name__, where, str(folder.resolve()))
    try:
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            timeout=timeout,
            env={**os.environ, "PYTHONPATH": paths},
            stdin=subprocess.DEVNULL,
        )
    except subprocess.TimeoutExpired:
        raise GripError(f"{where}: no tree was built in {timeout:g} s; give a factory that only builds") from None
    lines = done.stdout.splitlines()
    try:
        told = json.loads(lines[-1])
    except (IndexError, ValueError):
        words = done.stderr.strip().splitlines()[-1:] or ["it said nothing"]
        raise GripError(f"{where}: its process ended with status {done.returncode}: {words[0]}") from None
    if told.get("refused"):
        raise RefusedTreeError(tuple(Remark(*each) for each in told["refused"]))
    if "error" in told:
        raise GripError(f"{where}: {told['error']}")
    remarks = tuple(Remark(*each) for each in told["remarks"])
    return Imported(model.Task.model_validate(told["task"]), told["names"], remarks)


def _told(where: str) -> dict[str, Any]:
    """Return what the tree at a place is, as JSON holds it."""
    from py_trees.behaviour import Behaviour

    module, colon, name = where.partition(":")
    if not (module and colon and name):
        return {"error": "write `package.module:factory`"}
    try:
        found: Any = importlib.import_module(module)
        for part in name.split("."):
            found = getattr(found, part)
        found = found if isinstance(found, Behaviour) or not callable(found) else found()
        found = getattr(found, "root", found)  # a py_trees.trees.BehaviourTree holds its root
    except BaseException as error:  # noqa: BLE001 - somebody's code may do anything, sys.exit among it
        return {"error": f"{type(error).__name__}: {error}"}
    if not isinstance(found, Behaviour):
        return {"error": f"a {type(found).__name__} came out, which is no py_trees behaviour"}
    try:
        made = to_task(found)
    except RefusedTreeError as error:
        return {"refused": [(each.path, each.text) for each in error.refused]}
    task = made.task.model_dump(by_alias=True, exclude_unset=True, mode="json")
    return {"task": task, "names": made.names, "remarks": [(each.path, each.text) for each in made.remarks]}


def main(arguments: list[str]) -> None:
    """Tell on the last line of stdout what one factory builds; what the code itself prints goes to stderr."""
    sys.path.append(arguments[1])
    stdout, sys.stdout = sys.stdout, sys.stderr
    told = json.dumps(_told(arguments[0]))
    sys.stderr.flush()
    stdout.write(told + "\n")
    stdout.flush()
    os._exit(0)  # what the code left running doesn't keep us


if __name__ == "__main__":
    main(sys.argv[1:])
