"""Writes the wire models as TypeScript, through their JSON Schema: `python -m grip_gui.typescript`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter
from pydantic.json_schema import models_json_schema

from grip_gui.wire import editing, live, runs, setup, task

TARGET = Path(__file__).parent.parent / "frontend" / "src" / "protocol" / "generated.ts"
_HEAD = "// Written by `python -m grip_gui.typescript` from gui/grip_gui/wire/; don't edit.\n"
_SCALARS = {"string": "string", "integer": "number", "number": "number", "boolean": "boolean", "null": "null"}


def schema() -> dict[str, Any]:
    """Return the JSON Schema of all wire models under `$defs`; defaults count as present, as the server sends them."""
    rooms = (task, editing, runs, setup, live)
    models = [
        model
        for model in {name: model for room in rooms for name, model in vars(room).items()}.values()
        if isinstance(model, type) and issubclass(model, task.Wire) and model is not task.Wire
    ]
    _, definitions = models_json_schema([(model, "serialization") for model in models], ref_template="#/$defs/{model}")
    frame = TypeAdapter(runs.ServerFrame).json_schema(ref_template="#/$defs/{model}", mode="serialization")
    frame.pop("$defs", None)
    return {"$defs": {**definitions["$defs"], "ServerFrame": frame}}


def typescript() -> str:
    """Return the module's text: one exported type per model, sorted by name."""
    definitions = schema()["$defs"]
    return _HEAD + "".join(f"\n{_definition(name, definitions[name])}" for name in sorted(definitions))


def _definition(name: str, spec: dict[str, Any]) -> str:
    if spec.get("type") != "object":
        return f"export type {name} = {_type(spec)};\n"
    doc = spec.get("description", "").splitlines()
    comment = f"/** {doc[0]} */\n" if doc else ""
    required = set(spec.get("required", ()))
    fields = "".join(
        f"  {key}{'' if key in required else '?'}: {_type(value)};\n"
        for key, value in spec.get("properties", {}).items()
    )
    return f"{comment}export interface {name} {{\n{fields}}}\n"


def _type(spec: dict[str, Any]) -> str:
    if "$ref" in spec:
        return str(spec["$ref"]).rsplit("/", 1)[1]
    if "const" in spec:
        return json.dumps(spec["const"])
    if "enum" in spec:
        return " | ".join(json.dumps(value) for value in spec["enum"])
    for union in ("anyOf", "oneOf"):
        if union in spec:
            return " | ".join(_type(part) for part in spec[union])
    kind = spec.get("type")
    if kind == "array" and "prefixItems" in spec:
        return f"[{', '.join(_type(part) for part in spec['prefixItems'])}]"
    if kind == "array":
        item = _type(spec["items"])
        return f"({item})[]" if "|" in item else f"{item}[]"
    if kind == "object":
        values = spec.get("additionalProperties")
        return f"Record<string, {_type(values) if isinstance(values, dict) else 'unknown'}>"
    return _SCALARS.get(str(kind), "unknown")


if __name__ == "__main__":
    TARGET.write_text(typescript(), encoding="utf-8")
