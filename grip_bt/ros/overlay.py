"""Built interface packages made usable in this very process, and in those that we start.

Loading every library by its path is enough: `dlopen("libX.so")`, which ROS does later by bare name, first looks at
the names of the libraries that are already loaded. So an overlay can be added without LD_LIBRARY_PATH and without a
restart; taking one away, or a rebuilt one, needs a new process.
"""

from __future__ import annotations

import ctypes
import importlib
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from grip_bt.base.errors import GripError

from .interfaces.prefixes import python_folder


class OverlayError(GripError):
    """A prefix can't be used: nothing in it, another Python's, or its libraries don't load."""

    def __init__(self, prefix: Path, reason: str):
        self.prefix, self.reason = prefix, reason
        super().__init__(f"{prefix}: {reason}")


def package_prefixes(root: Path) -> list[Path]:
    """Return the prefixes below `root`: itself, or those of a colcon workspace's isolated `install/`.

    Raises:
        OverlayError: there is no ROS prefix.
    """
    if (root / "share" / "ament_index").is_dir():
        return [root]
    found = sorted(p for p in root.glob("*") if (p / "share" / "ament_index").is_dir()) if root.is_dir() else []
    if not found:
        raise OverlayError(root, "isn't a ROS prefix: share/ament_index is missing")
    return found


def activate(root: Path | str) -> list[Path]:
    """Make the interface packages of a prefix importable and usable in this process; again is harmless.

    Returns:
        the folders that were put in front of `sys.path`.

    Raises:
        OverlayError: no prefix, built for another Python, or a library doesn't load.
    """
    added, libraries = [], []
    for prefix in package_prefixes(Path(root)):
        folder = python_folder(prefix)
        if folder is None and any(prefix.glob("lib/python*/site-packages/*")):
            version = f"{sys.version_info.major}.{sys.version_info.minor}"
            raise OverlayError(prefix, f"was built for another Python than this one ({version}); build it again")
        if folder is not None and str(folder) not in sys.path:
            sys.path.insert(0, str(folder))
            added.append(folder)
        libraries += sorted((prefix / "lib").glob("lib*__rosidl_*.so"))
        _prepend("AMENT_PREFIX_PATH", prefix)
    importlib.invalidate_caches()
    _load(Path(root), libraries)
    return added


def child_paths(roots: Sequence[Path]) -> dict[str, list[Path]]:
    """Return what a child process needs in front of its search paths, by environment variable."""
    prefixes = [p for root in roots for p in package_prefixes(root)]
    return {
        "PYTHONPATH": [f for p in prefixes if (f := python_folder(p)) is not None],
        "LD_LIBRARY_PATH": [p / "lib" for p in prefixes],
        "AMENT_PREFIX_PATH": prefixes,
    }


def _load(root: Path, libraries: Sequence[Path]) -> None:
    """Load libraries, retrying those that need one that comes later."""
    todo, error = list(libraries), ""
    while todo:
        failed = []
        for library in todo:
            try:
                ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
            except OSError as reason:
                failed.append(library)
                error = str(reason)
        if len(failed) == len(todo):
            raise OverlayError(root, f"its libraries don't load: {error}")
        todo = failed


def _prepend(variable: str, path: Path) -> None:
    present = [p for p in os.environ.get(variable, "").split(os.pathsep) if p]
    if str(path) not in present:
        os.environ[variable] = os.pathsep.join([str(path), *present])
