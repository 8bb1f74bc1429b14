"""Task files in: text -> task, with the places of everything for messages."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path

from grip_bt.errors import DocumentError

from .allocation import many_made
from .migration import migrated, version_of
from .model import FORMAT_VERSION, Task
from .quick import quick_data
from .shape import CHILDREN, read_task, task_of
from .syntax import MAX_CHARACTERS, Entry, Mapping, Value, parse


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


def read_file(path: Path | str) -> str:
    """Return a file's text.

    Raises:
        DocumentError: there is no such file, or it isn't UTF-8 text of a sensible size.
    """
    name = str(path)
    if not name:  # of an unset variable of a shell, say; to `Path` it is the folder around
        raise DocumentError("a file's name is needed; this one is empty", "''")
    try:
        with Path(path).open("rb") as file:
            data = file.read(MAX_CHARACTERS + 1)
    except (FileNotFoundError, IsADirectoryError) as error:
        named = Path(path)
        meant = f"; it leads to {named.readlink()}" if named.is_symlink() else _meant(named)
        raise DocumentError(f"can't be read: {error.strerror}{meant}", name) from None
    except OSError as error:
        raise DocumentError(f"can't be read: {error.strerror or error}", name) from None
    except ValueError as error:
        raise DocumentError(f"can't be read: {error}", name) from None
    if len(data) > MAX_CHARACTERS:
        raise DocumentError(f"larger than {MAX_CHARACTERS} bytes; a task file is text", name)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        line, column = before.count(b"\n") + 1, error.start - before.rfind(b"\n")
        raise DocumentError(f"not text in UTF-8 (byte 0x{data[error.start]:02x})", name, line, column) from None


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


def _meant(path: Path) -> str:
    """Return what somebody probably meant who named a folder, or a file that isn't there; empty for no idea."""
    folder = path if path.is_dir() else path.parent
    try:
        there = sorted(str(file) for part in (folder, folder / "tasks") for file in part.glob("*.yaml"))
    except OSError:
        return ""
    there = [file for file in there if _can_be_meant(Path(file))]
    if path.is_dir():
        return f"; name a file in it, such as {there[0]}" if there else ""
    by_name = {Path(file).name: file for file in reversed(there)}
    close = get_close_matches(path.name, by_name, n=1)
    return f"; did you mean {by_name[close[0]]}?" if close else ""


def _can_be_meant(file: Path) -> bool:
    """Return whether a file may be a task, and its name can be put into a sentence."""
    listed = file.name.isprintable() and file.name != "grip.yaml" and not file.name.endswith(".layout.yaml")
    return listed and file.is_file()
