"""What was made of files, kept until one of them has changed: which were read, or looked for, is noted."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Generic, TypeVar

K = TypeVar("K", bound=Hashable)
T = TypeVar("T")
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


_MOST = 16
"""Things that are kept."""


class FileCache(Generic[K, T]):
    """What was made of files, made again when one of them has changed; of so many keys, the newest ones."""

    def __init__(self) -> None:
        self._made: dict[K, tuple[Stamps, T]] = {}

    def get(self, key: K, make: Callable[[], T]) -> T:
        """Return what `make` makes of the files that it notes, see `note`."""
        if key not in self._made or any(stamp != _stamp(stamp[0]) for stamp in self._made[key][0]):
            with noting_files() as files:
                made = make()
            self._made.pop(key, None)
            while len(self._made) >= _MOST:
                self._made.pop(next(iter(self._made)))
            self._made[key] = tuple(_stamp(str(file)) for file in sorted(files)), made
        return self._made[key][1]


def _stamp(file: str) -> tuple[str, int, int]:
    try:
        found = Path(file).stat()
    except OSError:
        return file, 0, -1
    return file, found.st_mtime_ns, found.st_size
