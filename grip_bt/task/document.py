"""Task files in: text -> syntax tree -> task, with every wrong key found, and the places of everything for messages."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pydantic import BaseModel, ValidationError

from grip_bt.base.errors import DocumentError, listing, nearest
from grip_bt.base.yaml.models import Diagnostic, diagnostic_of, document_error
from grip_bt.base.yaml.tree import (
    YamlEntry,
    YamlMapping,
    YamlScalar,
    YamlValue,
    inner,
    parse,
    read_file,
    to_data,
)
from grip_bt.task import model
from grip_bt.task.parts import FREE_PREFIX

from .model import FORMAT_VERSION, Task

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


def nodes_below(root: YamlValue) -> Iterator[YamlMapping]:
    """Yield a node and all below it that are mappings."""
    stack = [root]
    while stack:
        node = stack.pop()
        if isinstance(node, YamlMapping):
            yield node
            held = [node.entries[key].value for key in CHILDREN if key in node.entries]
            stack.extend(e.value for value in held if isinstance(value, YamlMapping) for e in value.entries.values())


def _key_faults(tree: YamlMapping) -> Iterator[Diagnostic]:
    yield from _unknown_keys(tree, model.Task, "a task")
    yield from _wrong_variables(tree)
    for node in nodes_below(tree.entries["root"].value) if "root" in tree.entries else ():
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


@dataclass(frozen=True)
class Document:
    """A task with the text that it was read from."""

    task: Task
    tree: YamlMapping
    text: str
    source: str = ""

    def position(self, path: str, key: str | tuple[str | int, ...] | None = None) -> tuple[int, int] | None:
        """Return the 1-based line and column of a node, or of a key within it; None when there is no such node.

        Args:
            path: a node's path (`/` is the root); an empty path is the task itself.
            key: a key of the node, or keys from the outside inwards such as `("in", "cloud")`. Where a key isn't in the
                file, the nearest place above it is returned.
        """
        entry = self._entry(path)
        if entry is None:
            return None
        line, column, value = entry.line, entry.column, entry.value
        for step in (key,) if isinstance(key, str) else key or ():
            found = inner(value, step)
            if found is None:
                break
            line, column, value = found.line, found.column, found.value
        return line, column

    def _entry(self, path: str) -> YamlEntry | None:
        if path == "":
            return YamlEntry("", self.tree, self.tree.line, self.tree.column)
        entry: YamlEntry | None = self.tree.entries["root"]
        for name in path.split("/") if path != "/" else ():
            held = next((found for key in CHILDREN if entry and (found := inner(entry.value, key))), None)
            entry = inner(held.value, name) if held else None
        return entry


def read(source: Path | str) -> Document:
    """Read a task from a file, given as a `Path` or as a one-line string, or from a text of several lines.

    Raises:
        DocumentError: it can't be read, or isn't a task.
    """
    if isinstance(source, str) and "\n" in source:
        return read_text(source)
    return read_text(read_file(source), str(source))


def read_text(text: str, source: str = "") -> Document:
    """Read a task from a text, which `source` names in messages; DocumentError where it isn't a task."""
    tree = parse(text, source)
    _check_version(tree, source)
    task = read_task(tree, source)
    assert isinstance(tree, YamlMapping), "as a task is one"
    return Document(task, tree, text, source)


def _check_version(tree: YamlValue, source: str) -> None:
    """Refuse a file of another format than ours.

    Whoever changes the format raises `FORMAT_VERSION` and reads the version before it here.
    """
    entry = tree.entries.get("grip") if isinstance(tree, YamlMapping) else None
    version = entry.value.value if entry is not None and isinstance(entry.value, YamlScalar) else None
    if entry is None or type(version) is not int or version == FORMAT_VERSION:
        return
    message = f"format {version} isn't supported; this version of GRIP reads `grip: {FORMAT_VERSION}`"
    if version > FORMAT_VERSION:
        newer = f"format {version} is newer than this version of GRIP reads ({FORMAT_VERSION})"
        message = f"{newer}; run `pip install -U grip-bt`"
    raise DocumentError(message, source, entry.value.line, entry.value.column)


def load(path: Path | str) -> Task:
    """Read a task file; DocumentError where it can't be read, or isn't a task."""
    task = read_text(read_file(path), str(path)).task
    task._file = str(Path(path).absolute())
    return task


def loads(text: str, source: str = "") -> Task:
    """Read a task from text, which `source` names in messages; DocumentError where it isn't a task."""
    return read_text(text, source).task
