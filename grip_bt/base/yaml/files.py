"""A text file, read with sentences that say what is wrong with it."""

from __future__ import annotations

from difflib import get_close_matches
from pathlib import Path

from grip_bt.base.errors import DocumentError

from .syntax import MAX_CHARACTERS


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
