"""Which files a robot was read from, so that it is read again when one of them has changed, and only then."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

Stamps = tuple[tuple[str, int, int], ...]
"""Of each file: its path, when it was written [ns] and its size [B]; 0 and -1 where it isn't there."""
_files: ContextVar[set[Path] | None] = ContextVar("files", default=None)


@contextmanager
def noting_files() -> Iterator[set[Path]]:
    """Collect the files that are read by this thread from here on."""
    outer, files = _files.get(), set[Path]()
    token = _files.set(files)
    try:
        yield files
    finally:
        _files.reset(token)
        if outer is not None:
            outer |= files


def note(*paths: Path) -> None:
    """Say that files are read, or looked for."""
    files = _files.get()
    if files is not None:
        files.update(path.absolute() for path in paths)


def stamps_of(files: Iterable[Path | str]) -> Stamps:
    """Return what tells whether files are still as they were."""
    return tuple(_stamp(str(file)) for file in sorted(map(str, files)))


def as_they_were(stamps: Iterable[Iterable[object]]) -> bool:
    """Tell whether no file has changed since its stamp was taken."""
    return all(tuple(stamp) == _stamp(str(next(iter(stamp)))) for stamp in stamps)


def _stamp(file: str) -> tuple[str, int, int]:
    try:
        found = Path(file).stat()
    except OSError:
        return file, 0, -1
    return file, found.st_mtime_ns, found.st_size
