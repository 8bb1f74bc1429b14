"""Task files in: text -> task, with the places of everything for messages."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from grip_bt.base.errors import DocumentError
from grip_bt.base.yaml.tree import YamlEntry, YamlMapping, YamlScalar, YamlValue, parse, read_file

from .model import FORMAT_VERSION, Task
from .shape import CHILDREN, read_task


@dataclass(frozen=True)
class Document:
    """A task with the text that it was read from."""

    task: Task
    tree: YamlMapping
    text: str
    source: str = ""

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

    def _entry(self, path: str) -> YamlEntry | None:
        if path == "":
            return YamlEntry("", self.tree, self.tree.line, self.tree.column)
        entry: YamlEntry | None = self.tree.entries["root"]
        for name in path.split("/") if path != "/" else ():
            entry = _child(entry, name)
        return entry


def _child(entry: YamlEntry | None, name: str) -> YamlEntry | None:
    if entry is None or not isinstance(entry.value, YamlMapping):
        return None
    for key in CHILDREN:
        children = entry.value.entries.get(key)
        if children is not None and isinstance(children.value, YamlMapping):
            return children.value.entries.get(name)
    return None


def _inner(value: YamlValue, step: str | int) -> YamlEntry | None:
    if isinstance(value, YamlMapping):
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
    """Read a task file.

    Raises:
        DocumentError: it can't be read, or isn't a task.
    """
    task = read_text(read_file(path), str(path)).task
    task._file = str(Path(path).absolute())
    return task


def loads(text: str, source: str = "") -> Task:
    """Read a task from text; `source` names it in messages.

    Raises:
        DocumentError: it isn't a task.
    """
    return read_text(text, source).task
