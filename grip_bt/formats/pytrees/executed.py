"""The process in which the code that builds a tree runs: it tells the tree's task and ends."""

from __future__ import annotations

import importlib
import json
import os
import sys
from typing import Any

from py_trees.behaviour import Behaviour

from grip_bt.formats.imported import ImportRefusedError

from .tree import to_task


def told(where: str) -> dict[str, Any]:
    """Return what the tree at `package.module:factory` is, as JSON holds it."""
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
    except ImportRefusedError as error:
        return {"refused": [issue.as_dict() for issue in error.issues]}
    task = made.task.model_dump(by_alias=True, exclude_unset=True, mode="json")
    return {"task": task, "issues": [issue.as_dict() for issue in made.issues]}


def main(where: str) -> None:
    """Tell on the last line of stdout what one factory builds; what the code itself prints goes to stderr."""
    stdout, sys.stdout = sys.stdout, sys.stderr
    answer = json.dumps(told(where))
    sys.stderr.flush()
    stdout.write(answer + "\n")
    stdout.flush()
    os._exit(0)  # what the code left running doesn't keep us


if __name__ == "__main__":
    main(sys.argv[1])
