"""The JSON Schema of task files, made from the models; `docs/task.schema.json` is its published copy."""

from __future__ import annotations

from typing import Any

from grip_bt.task.model import Task
from grip_bt.task.parts import FREE_PREFIX

_TITLE = "GRIP task, format 1"


def schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a task file; free keys are `x-*` in a task and in a node."""
    made = Task.model_json_schema(by_alias=True)
    shapes = [made, *(s for s in made.get("$defs", {}).values() if "*" in s.get("properties", {}))]
    for shape in shapes:
        shape["properties"].pop("*")
        shape["patternProperties"] = {f"^{FREE_PREFIX}": {}}
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **made, "title": _TITLE}
