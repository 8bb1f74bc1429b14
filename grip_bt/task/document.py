"""Task files in: text -> task, with the places of everything for messages."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from grip_bt.base.yaml.files import read_file
from grip_bt.base.yaml.syntax import Entry, Mapping, Value, parse

from .allocation import many_made
from .migration import migrated, version_of
from .model import FORMAT_VERSION, Task
from .quick import quick_data
from .shape import CHILDREN, read_task, task_of


@dataclass(frozen=True)
class Document:
    """A task with the text that it was read from.

    Attributes:
        task: the task.
        text: the file's text.
        source: the file's name as it was given, for messages.
        written_as: the version of the format that the file has; `text` is in the one that is read.
    """

    task: Task
    text: str
    source: str = ""
    written_as: int = FORMAT_VERSION

    @cached_property
    def tree(self) -> Mapping:
        """The text's syntax, with places; parsed when somebody asks."""
        with many_made(self.text):
            tree = parse(self.text, self.source)
        assert isinstance(tree, Mapping)
        return tree

    def position(self, path: str, key: str | tuple[str | int, ...] | None = None) -> tuple[int, int] | None:
        """Return the 1-based line and column of a node, or of a key within it.

        Args:
            path: a node's path (`/` is the root); an empty path is the task itself.
            key: a key of the node, or keys from the outside inwards such as `("in", "cloud")`. Where a key isn't in the
                file, the nearest place above it is returned.

        Returns:
            None when there is no node at `path`.
        """
        entry = self._entry(path)
        if entry is None:
            return None
        line, column, value = entry.line, entry.column, entry.value
        for step in (key,) if isinstance(key, str) else key or ():
            inner = _inner(value, step)
            if inner is None:
                break
            line, column, value = inner.line, inner.column, inner.value
        return line, column

    def _entry(self, path: str) -> Entry | None:
        if path == "":
            return Entry("", self.tree, self.tree.line, self.tree.column)
        entry: Entry | None = self.tree.entries["root"]
        for name in path.split("/") if path != "/" else ():
            entry = _child(entry, name)
        return entry


def _child(entry: Entry | None, name: str) -> Entry | None:
    if entry is None or not isinstance(entry.value, Mapping):
        return None
    for key in CHILDREN:
        children = entry.value.entries.get(key)
        if children is not None and isinstance(children.value, Mapping):
            return children.value.entries.get(name)
    return None


def _inner(value: Value, step: str | int) -> Entry | None:
    if isinstance(value, Mapping):
        return value.entries.get(str(step))
    entries = getattr(value, "entries", [])
    return entries[step] if isinstance(step, int) and 0 <= step < len(entries) else None


def read(source: Path | str) -> Document:
    """Read a task from a file, given as a `Path` or as a one-line string, or from a text of several lines.

    Raises:
        DocumentError: it can't be read, or isn't a task.
    """
    if isinstance(source, str) and "\n" in source:
        return read_text(source)
    return read_text(read_file(source), str(source))


def read_text(text: str, source: str = "") -> Document:
    """Read a task from a text; `source` names it in messages.

    Raises:
        DocumentError: it isn't a task.
    """
    with many_made(text):
        data = quick_data(text)
        task = None if data is None else task_of(data)
        if task is None:
            # odd or wrong: with places, so that a fault is said where it is
            tree = parse(text, source)
            new = migrated(text, tree, source)
            if new != text:
                return Document(read_task(parse(new, source), source), new, source, version_of(tree) or 0)
            task = read_task(tree, source)
        return Document(task, text, source)


def load(path: Path | str) -> Task:
    """Read a task file.

    Raises:
        DocumentError: it can't be read, or isn't a task.
    """
    return read_text(read_file(path), str(path)).task


def loads(text: str, source: str = "") -> Task:
    """Read a task from text; `source` names it in messages.

    Raises:
        DocumentError: it isn't a task.
    """
    return read_text(text, source).task
