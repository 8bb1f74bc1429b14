"""Short tasks for these tests."""

from __future__ import annotations

from typing import Any

from grip_bt.task import Task
from grip_bt.task.catalog import Catalog, Manifest

CATALOG = Catalog(
    [
        Manifest(
            id="test/act",
            doc="Acts.",
            implementation="tests:Act",
            outputs={"x": {"type": "int"}},
            outcomes={"success": "success", "failure": "failure"},
        )
    ]
)


def leaf(**more: Any) -> dict[str, Any]:
    return {"node": "test/act", **more}


def task(root: dict[str, Any], **more: Any) -> Task:
    return Task.model_validate({"grip": 1, "name": "tested", "root": root, **more})


def machine(initial: str, states: dict[str, dict[str, str]], **outcomes: str) -> dict[str, Any]:
    """Return a machine of leaves; by default its outcomes are success and failure."""
    return {
        "kind": "state_machine",
        "initial": initial,
        "outcomes": outcomes or {"success": "success", "failure": "failure"},
        "children": {name: leaf(on=on) for name, on in states.items()},
    }
