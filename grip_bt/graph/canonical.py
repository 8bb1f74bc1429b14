"""The canonical form: the order of keys, what is left out because it says nothing, what stands one entry a line.

`dumps` writes a task in it, `fmt` brings a person's text into it and keeps the comments; without comments and
blank lines both give the same bytes.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

from . import model
from .shape import CHILDREN, FREE, child_nodes, keys_of, model_of
from .syntax import Entry, Mapping, Scalar, Value, entries_of, plain, tree_of
from .writer import write


def dumps(task: model.Task) -> str:
    """Return a task as canonical YAML.

    Raises:
        TypeError: a literal is of a type that a task file can't hold.
    """
    tree = tree_of(_task_data(task))
    assert isinstance(tree, Mapping)
    return write_canonical(tree)


def write_canonical(tree: Mapping, header: list[str] | None = None) -> str:
    """Return the canonical text of the syntax tree of a readable task."""
    blocks = {id(tree)}
    _arrange(tree, model.Task)
    for node in _nodes(tree):
        shape = model_of(node) or model.Leaf
        _arrange(node, shape)
        if shape is not model.Leaf:
            blocks.add(id(node))
            blocks.update(id(node.entries[key].value) for key in CHILDREN if key in node.entries)
    return write(tree, lambda value: id(value) in blocks and _filled(value), header)


def _filled(value: Value) -> bool:
    return isinstance(value, Mapping) and bool(value.entries)


def _nodes(tree: Mapping) -> Iterator[Mapping]:
    stack = [tree.entries["root"].value]
    while stack:
        node = stack.pop()
        if isinstance(node, Mapping):
            yield node
            stack.extend(child.value for _, child in child_nodes(node))


def _arrange(node: Mapping, shape: type[BaseModel]) -> None:
    """Order a node's or the task's entries and drop those that only repeat a default."""
    order = keys_of(shape)
    last = len(order) - sum(key in order for key in ("root", *CHILDREN))
    rank = {key: position for position, key in enumerate(order)}
    defaults = {
        field.alias or name: field.get_default(call_default_factory=True)
        for name, field in shape.model_fields.items()
        if not field.is_required()
    }
    entries = sorted(node.entries.values(), key=lambda e: rank.get(e.key, last - 0.5))
    node.entries = {e.key: e for e in entries if not _says_nothing(e, defaults)}
    seconds = node.entries.get("seconds")
    if seconds is not None and isinstance(seconds.value, Scalar):
        seconds.value.value = _shortest(seconds.value.value)


def _says_nothing(entry: Entry, defaults: dict[str, Any]) -> bool:
    if entry.key not in defaults or entry.comments.any() or _has_comments(entry.value):
        return False
    value, default = plain(entry.value), defaults[entry.key]
    if isinstance(value, dict):
        return isinstance(default, dict) and list(value.items()) == list(default.items())
    return type(value) is type(default) and bool(value == default)


def _has_comments(value: Value) -> bool:
    return bool(getattr(value, "closing", ())) or any(
        e.comments.any() or _has_comments(e.value) for e in entries_of(value)
    )


def _shortest(number: Any) -> Any:
    if isinstance(number, float) and number.is_integer() and abs(number) < 2**53:
        return int(number)
    return number


def _task_data(task: model.Task) -> dict[str, Any]:
    data = _data(task, ("root",))
    data["root"] = None
    todo: list[tuple[Any, str, dict[str, Any]]] = [(task.root, "root", data)]
    while todo:
        node, key, parent = todo.pop()
        parent[key] = mine = _data(node, CHILDREN)
        below = model.children_of(node)
        if not isinstance(node, model.Leaf):
            children: dict[str, Any] = dict.fromkeys(below)
            mine["child" if hasattr(node, "child") else "children"] = children
            todo.extend((child, name, children) for name, child in below.items())
    return data


def _data(shape: BaseModel, skipped: tuple[str, ...]) -> dict[str, Any]:
    """Return a task's or node's own keys as plain data."""
    data: dict[str, Any] = {}
    for name, field in type(shape).model_fields.items():
        value = getattr(shape, name)
        if name in skipped:
            continue
        if name == "x":
            data.update((k, v) for k, v in value.items() if k.startswith(FREE))
        elif name == "data":
            data[name] = {k: _variable(v) for k, v in value.items()}
        elif field.is_required() or name in shape.model_fields_set or value != field.default:
            data[field.alias or name] = value
    return data


def _variable(variable: model.Variable | str) -> Any:
    if isinstance(variable, str):
        return variable
    data: dict[str, Any] = {"type": variable.type}
    if variable.has_value:
        data["value"] = variable.value
    if variable.doc:
        data["doc"] = variable.doc
    return data
