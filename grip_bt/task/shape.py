"""Syntax tree -> the models' input, with every wrong key and every value of a wrong kind found and placed.

The keys of a file are the fields of the models (by their aliases), plus free keys `x-*` in a task and in a node.
"""

from __future__ import annotations

from collections.abc import Iterator

from pydantic import BaseModel, ValidationError

from grip_bt.base.errors import DocumentError, listing, nearest
from grip_bt.base.yaml.models import Diagnostic, diagnostic_of, document_error
from grip_bt.base.yaml.tree import YamlEntry, YamlMapping, YamlValue, to_data
from grip_bt.task import model
from grip_bt.task.model import Task
from grip_bt.task.parts import FREE_PREFIX

CHILDREN = ("children", "child")
DECLARING = ("inputs", "outputs", "data")
"""Keys that hold variables."""


def keys_of(shape: type[BaseModel]) -> tuple[str, ...]:
    """Return the keys that a mapping of this model may have in a file, in their canonical order; without `x-*`."""
    names = [field.alias or name for name, field in shape.model_fields.items() if name != "x"]
    return tuple(sorted(names, key=_ORDER.index))


_FIRST = ("grip", "name", "kind", "node", "type", "value", "doc", "precondition")
_LAST = (
    *("task", "behaviour", "args", "with", "in", "out", "meaning", "outcomes", "exits", "on"),
    *("inputs", "outputs", "data", "root", "children", "child"),
)


def _in_order() -> tuple[str, ...]:
    """Return all keys: the kinds' own, in the order of their models, between those of every node."""
    found: list[str] = []
    for kind in model.KINDS.values():
        following = len(found)
        for name, field in reversed(kind.model_fields.items()):
            key = field.alias or name
            if key in found:
                following = found.index(key)
            elif key not in (*_FIRST, *_LAST, "x"):
                found.insert(following, key)
    return (*_FIRST, *found, *_LAST)


_ORDER = _in_order()


def key_rank(key: str) -> float:
    """Return a number by which the keys of a node or a task are in canonical order."""
    return _ORDER.index(key) if key in _ORDER else _ORDER.index("root") - 0.5


def model_of(node: YamlMapping) -> type[BaseModel] | None:
    """Return the model of a node, None when its `kind` is unknown."""
    entry = node.entries.get("kind")
    if entry is None:
        return model.Leaf
    kind = to_data(entry.value)
    return model.KINDS.get(kind) if isinstance(kind, str) else None


def model_of_kind(kind: str) -> type[model.Kind]:
    """Return the model of a kind of container; KeyError when there is none."""
    return model.KINDS[kind]


def child_nodes(node: YamlMapping) -> Iterator[tuple[str, YamlEntry]]:
    """Yield the entries of a node's children whose values are mappings, by name."""
    for key in CHILDREN:
        entry = node.entries.get(key)
        if entry is not None and isinstance(entry.value, YamlMapping):
            for name, child in entry.value.entries.items():
                if isinstance(child.value, YamlMapping):
                    yield name, child


def read_task(tree: YamlValue, source: str) -> model.Task:
    """Turn a syntax tree into a task.

    Raises:
        DocumentError: with the first fault and its place; the message lists the others.
    """
    if not isinstance(tree, YamlMapping):
        raise DocumentError("a task is a mapping that begins with `grip: 1`", source, tree.line, tree.column)
    faults = list(_key_faults(tree))
    if faults:
        raise document_error(faults, source)
    try:
        return model.Task.model_validate(to_data(tree), strict=True, by_name=False)
    except ValidationError as error:
        raise document_error([diagnostic_of(tree, e) for e in error.errors()], source) from None


def _nodes(tree: YamlMapping) -> Iterator[YamlMapping]:
    root = tree.entries.get("root")
    stack = [root.value] if root is not None and isinstance(root.value, YamlMapping) else []
    while stack:
        node = stack.pop()
        yield node
        stack.extend(child.value for _, child in child_nodes(node))  # type: ignore[misc]


def _key_faults(tree: YamlMapping) -> Iterator[Diagnostic]:
    yield from _unknown_keys(tree, model.Task, "a task")
    yield from _wrong_variables(tree)
    for node in _nodes(tree):
        shape = model_of(node)
        if shape is None:
            entry = node.entries["kind"]
            kind = to_data(entry.value)
            leaf = isinstance(kind, str) and "/" in kind  # as ids of the catalogue have, and no container has
            hint = f"; a leaf is written `node: {kind}`" if leaf else nearest(str(kind), model.KINDS)
            allowed = listing(model.KINDS)
            yield (f"unknown kind {kind!r}{hint} (available: {allowed})", entry.value.line, entry.value.column)
            continue
        name = "a leaf" if shape is model.Leaf else f"a {to_data(node.entries['kind'].value)}"
        if shape is model.Leaf and "node" not in node.entries:
            yield ("a node needs `node:` (a leaf) or `kind:` (a container)", node.line, node.column)
        yield from _unknown_keys(node, shape, name)
        yield from _wrong_variables(node)


def _unknown_keys(node: YamlMapping, shape: type[BaseModel], name: str, free: bool = True) -> Iterator[Diagnostic]:
    allowed = keys_of(shape)
    for key, entry in node.entries.items():
        if key not in allowed and not (free and key.startswith(FREE_PREFIX)):
            hint = nearest(key, allowed)
            extra = ", and free keys x-*" if free else ""
            yield (
                f"unknown key {key!r} in {name}{hint} (available: {listing(allowed)}{extra})",
                entry.line,
                entry.column,
            )


def _wrong_variables(node: YamlMapping) -> Iterator[Diagnostic]:
    found = [node.entries[key].value for key in DECLARING if key in node.entries]
    for name, entry in ((n, e) for value in found if isinstance(value, YamlMapping) for n, e in value.entries.items()):
        if isinstance(entry.value, YamlMapping):
            yield from _unknown_keys(entry.value, model.Variable, f"the variable {name!r}", free=False)
        elif not isinstance(to_data(entry.value), str):
            yield (
                f"the variable {name!r} is a type, or {{type: ..., value: ...}}",
                entry.value.line,
                entry.value.column,
            )


_TITLE = "GRIP task, format 1"


def schema() -> dict[str, object]:
    """Return the JSON Schema (draft 2020-12) of a task file; free keys are `x-*` in a task and in a node."""
    made = Task.model_json_schema(by_alias=True)
    shapes = [made, *(s for s in made.get("$defs", {}).values() if "*" in s.get("properties", {}))]
    for shape in shapes:
        shape["properties"].pop("*")
        shape["patternProperties"] = {f"^{FREE_PREFIX}": {}}
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **made, "title": _TITLE}
