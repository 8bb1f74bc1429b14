"""The process in which the code that builds a tree runs: it tells the tree's task and ends."""

from __future__ import annotations

import json
import os
import sys
from typing import Any

from grip_bt.base.errors import GripError
from grip_bt.formats.imported import Imported, ImportRefusedError
from grip_bt.nodes.tree_code import find_tree, place_of
from grip_bt.task import Task

from .tree import drawn, to_task


def told(where: str, as_it_is: bool = False) -> dict[str, Any]:
    """Return what the tree that code makes is, as JSON holds it; `as_it_is` for a drawing of it."""
    try:
        place = place_of(where)
        root = find_tree(place).tree.root
        if as_it_is:
            return {"task": _plain(drawn(root, where)[0]), "issues": []}
        made: Imported = to_task(root, built_by="" if place.arguments else f"{place.import_name}:{place.name}")
    except ImportRefusedError as error:
        return {"refused": [issue.as_dict() for issue in error.issues]}
    except GripError as error:
        return {"error": str(error)}
    return {"task": _plain(made.task), "issues": [issue.as_dict() for issue in made.issues]}


def _plain(task: Task) -> dict[str, Any]:
    return task.model_dump(by_alias=True, exclude_unset=True, mode="json")


def main(where: str, *as_it_is: str) -> None:
    """Tell on the last line of stdout what one factory builds; what the code itself prints goes to stderr."""
    stdout, sys.stdout = sys.stdout, sys.stderr
    answer = json.dumps(told(where, bool(as_it_is)))
    sys.stderr.flush()
    stdout.write(answer + "\n")
    stdout.flush()
    os._exit(0)  # what the code left running doesn't keep us


if __name__ == "__main__":
    main(*sys.argv[1:])
