"""The only place where generated files touch the disk: each is replaced as a whole or not at all."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from grip_bt.base.errors import GripError
from grip_bt.base.files import replace_text

from .render import MARK


class NotOursError(GripError):
    """A file that would be overwritten wasn't generated."""

    def __init__(self, path: Path):
        self.path = path
        super().__init__(f"{path} was not generated and would be overwritten; move it, or choose another folder")


def outdated(folder: Path, files: Mapping[str, str]) -> list[str]:
    """Return the paths of files that are missing in `folder`, differ, or were generated once and aren't any more."""
    wrong = [path for path, text in files.items() if _read(folder / path) != text]
    return sorted([*wrong, *(p.name for p in _left_over(folder, files))])


def write_package(folder: Path, files: Mapping[str, str]) -> list[str]:
    """Make `folder` hold `files`; return the paths that were written or removed.

    Raises:
        NotOursError: a file is in the way that wasn't generated; nothing was written.
    """
    changed = outdated(folder, files)
    for path in files:
        present = _read(folder / path)
        if present is not None and MARK not in present:
            raise NotOursError(folder / path)
    for path in changed:
        if path in files:
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            replace_text(folder / path, files[path])
        else:
            (folder / path).unlink()
    return changed


def _left_over(folder: Path, files: Mapping[str, str]) -> list[Path]:
    if not folder.is_dir():
        return []
    others = (p for p in sorted(folder.iterdir()) if p.is_file() and p.name not in files)
    return [p for p in others if MARK in (_read(p) or "")[:200]]


def _read(path: Path) -> str | None:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return None
