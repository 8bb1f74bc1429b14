"""The canonical form: the order of keys, what is left out because it says nothing, what stands one entry a line."""

from __future__ import annotations

from pydantic import BaseModel

from grip_bt.base.types import Value
from grip_bt.base.yaml.tree import YamlEntry, YamlMapping, YamlScalar, YamlValue, entries_of, from_data, to_data
from grip_bt.base.yaml.writer import write
from grip_bt.task import model

from .comments import attach_comments
from .document import CHILDREN, DECLARING, keys_of, model_of, nodes_below, read_text
from .parts import FREE_PREFIX


def dumps(task: model.Task) -> str:
    """Return a task as canonical YAML; TypeError where a literal is of a type that a task file can't hold."""
    tree = from_data(file_data(task))
    assert isinstance(tree, YamlMapping)
    return _write_canonical(tree)


def _write_canonical(tree: YamlMapping, header: list[str] | None = None) -> str:
    blocks = {id(tree)}
    _arrange(tree, model.Task)
    for node in nodes_below(tree.entries["root"].value):
        _arrange_node(node, blocks)
    return write(tree, lambda value: id(value) in blocks and _filled(value), header)


def _filled(value: YamlValue) -> bool:
    return isinstance(value, YamlMapping) and bool(value.entries)


def _arrange_node(node: YamlMapping, blocks: set[int], whole: bool = False) -> None:
    shape = model_of(node) or model.Leaf
    _arrange(node, shape, whole)
    if not shape.model_fields.keys().isdisjoint(CHILDREN):
        blocks.add(id(node))
        blocks.update(id(node.entries[key].value) for key in CHILDREN if key in node.entries)


def _arrange(node: YamlMapping, shape: type[BaseModel], whole: bool = False) -> None:
    """Order a node's or the task's entries and drop those that only repeat a default, unless `whole`."""
    order = keys_of(shape)
    last = len(order) - sum(key in order for key in ("root", *CHILDREN))
    rank = {key: position for position, key in enumerate(order)}
    defaults = {
        field.alias or name: field.get_default(call_default_factory=True)
        for name, field in shape.model_fields.items()
        if not field.is_required()
    }
    entries = sorted(node.entries.values(), key=lambda e: rank.get(e.key, last - 0.5))
    node.entries = {e.key: e for e in entries if whole or not _says_nothing(e, defaults)}
    seconds = node.entries.get("seconds")
    if seconds is not None and isinstance(seconds.value, YamlScalar):
        seconds.value.value = _shortest(seconds.value.value)


def _says_nothing(entry: YamlEntry, defaults: dict[str, object]) -> bool:
    if entry.key not in defaults or entry.comments.any() or _has_comments(entry.value):
        return False
    value, default = to_data(entry.value), defaults[entry.key]
    if isinstance(value, dict):
        return isinstance(default, dict) and list(value.items()) == list(default.items())
    return type(value) is type(default) and bool(value == default)


def _has_comments(value: YamlValue) -> bool:
    return bool(getattr(value, "closing", ())) or any(
        e.comments.any() or _has_comments(e.value) for e in entries_of(value)
    )


def _shortest(number: object) -> object:
    if isinstance(number, float) and number.is_integer() and abs(number) < 2**53:
        return int(number)
    return number


def file_data(value: object) -> Value:
    """Return what stands in a file for a task or a part of one."""
    if isinstance(value, BaseModel):
        value = data_of(value)
    if isinstance(value, dict):
        return {key: file_data(inner) for key, inner in value.items()}
    return [file_data(inner) for inner in value] if isinstance(value, list | tuple) else value


def data_of(shape: BaseModel) -> dict[str, object]:
    """Return the keys of a task or a node as they stand in a file; nodes in it are left as models."""
    data: dict[str, object] = {}
    for name, field in type(shape).model_fields.items():
        value = getattr(shape, name)
        if name == "x":
            data.update((k, v) for k, v in value.items() if k.startswith(FREE_PREFIX))
        elif (
            field.is_required()
            or name in shape.model_fields_set
            or value != field.get_default(call_default_factory=True)
        ):
            data[field.alias or name] = (
                {k: _variable(v) for k, v in value.items()} if name in DECLARING else _plain(value)
            )
    return data


def _plain(value: object) -> object:
    if not isinstance(value, list):
        return value
    return [entry.model_dump(exclude_defaults=True) if isinstance(entry, BaseModel) else entry for entry in value]


def _variable(variable: model.Variable | str) -> object:
    if isinstance(variable, str):
        return variable
    data: dict[str, object] = {"type": variable.type}
    if variable.has_value:
        data["value"] = variable.value
    if variable.doc:
        data["doc"] = variable.doc
    return data


def lines_of(key: str, value: object, node: bool, beside: str = "") -> list[str]:
    """Return the lines of one entry in canonical order and layout, indented from column 0; nothing is left out.

    Args:
        beside: a comment for the end of its first line.
    """
    entry = YamlEntry(key, from_data(value))
    entry.comments.beside = beside
    blocks: set[int] = set()
    if node and isinstance(entry.value, YamlMapping):
        for inner in nodes_below(entry.value):
            _arrange_node(inner, blocks, whole=True)
    text = write(YamlMapping({key: entry}), lambda part: id(part) in blocks and _filled(part))
    return text.removesuffix("\n").split("\n")


def fmt(text: str, source: str = "") -> str:
    """Return the canonical form of a task's text, with its comments; of an older format, in the one that is read.

    Formatting twice changes nothing more, and the task stays equal.

    Raises:
        DocumentError: the text isn't a task.
    """
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    document = read_text(text, source)
    header = attach_comments(document.tree, document.text)
    return _write_canonical(document.tree, header)
