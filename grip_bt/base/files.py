"""Files that are replaced in one step: a reader sees the old content or the new; copies; and what a `with` closes."""

from __future__ import annotations

import errno
import os
import shutil
import stat
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Self


def replace_text(path: Path, text: str) -> None:
    """Replace a file by a text in UTF-8; see `replace_bytes`."""
    replace_bytes(path, text.encode("utf-8"))


def replace_bytes(path: Path, data: bytes, durable: bool = False) -> None:
    """Replace a file, wholly or not at all; its permissions stay, and a link still leads to it.

    Args:
        path: the file; it may not be there yet, but its folder is.
        durable: whether it has to be on the disk before the old content goes: a power cut leaves one of the two.

    Raises:
        OSError: it can't be written; its `filename` is the path.
    """
    path = path.resolve()
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    try:
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name[:100]}.")
    except OSError as error:  # of the file that was named, not of ours beside it
        raise OSError(error.errno, error.strerror, str(path)) from None
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            if durable:
                file.flush()
                os.fsync(file.fileno())
        if path.exists():
            shutil.copymode(path, temporary)
        else:
            umask = os.umask(0)
            os.umask(umask)
            Path(temporary).chmod(0o666 & ~umask)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def text_in(path: Path) -> str | None:
    """Return a file's text; None where it can't be read, or isn't text in UTF-8."""
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return None


def copy_folder(folder: Path, copy: Path, ignore: Callable[[str, list[str]], Iterable[str]] | None = None) -> None:
    """Copy a folder that may be read-only, as installed ones are; whoever copies may write to all of the copy."""
    shutil.copytree(folder, copy, ignore=ignore)
    for path in (copy, *copy.rglob("*")):
        path.chmod(path.stat().st_mode | stat.S_IWUSR)


class Closing(ABC):
    """Something that holds a process, a connection or a file until it is closed."""

    @abstractmethod
    def close(self) -> None:
        """Let go of it; harmless when repeated."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
