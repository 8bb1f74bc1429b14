"""ROS packages that are installed, sourced or built here: their folders and their programs."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from grip_bt.base.errors import GripError, nearest

from .interfaces.prefixes import search_path, share_folder


class PackageError(GripError):
    """A package, a program of one, or a launch file of one isn't here; it says what is."""


def share_of(package: str, prefixes: Sequence[Path] | None = None) -> Path:
    """Return the `share` folder of a package.

    Raises:
        PackageError: there is no such package.
    """
    roots = search_path() if prefixes is None else list(prefixes)
    found = share_folder(package, roots)
    if found is None:
        known = {folder.name for root in roots if (root / "share").is_dir() for folder in (root / "share").iterdir()}
        raise PackageError(
            f"no ROS package {package!r} here{nearest(package, known)}; looked in {', '.join(map(str, roots))}. "
            "Source the workspace that has it (source install/setup.bash), or install it"
        )
    return found


def prefix_of(package: str, prefixes: Sequence[Path] | None = None) -> Path:
    """Return the prefix in which a package is installed; raises PackageError likewise."""
    return share_of(package, prefixes).parent.parent


def executable_of(package: str, name: str, prefixes: Sequence[Path] | None = None) -> Path:
    """Return the file of a package's program.

    Raises:
        PackageError: there is no such package, or it has no such program.
    """
    folder = prefix_of(package, prefixes) / "lib" / package
    file = folder / name
    if file.is_file() and os.access(file, os.X_OK):
        return file
    known = sorted(f.name for f in folder.iterdir() if f.is_file() and os.access(f, os.X_OK)) if folder.is_dir() else []
    has = ", ".join(known) or "none"
    raise PackageError(f"{package} has no program {name!r}{nearest(name, known)} in {folder} (there are: {has})")


def launch_file_of(package: str, name: str, prefixes: Sequence[Path] | None = None) -> Path:
    """Return a package's launch file, from its `launch/` folder or anywhere in its share.

    Raises:
        PackageError: there is no such package, or it has no such file.
    """
    share = share_of(package, prefixes)
    for candidate in (share / "launch" / name, share / name):
        if candidate.is_file():
            return candidate
    known = sorted(f.relative_to(share).as_posix() for f in share.glob("**/*launch*") if f.is_file())
    has = ", ".join(known) or "none"
    raise PackageError(f"{package} has no launch file {name!r}{nearest(name, known)} in {share} (there are: {has})")
