"""Where installed interface packages are: the wheels' environment, a sourced ROS, a built overlay."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path


def search_path(overlays: Sequence[Path] = ()) -> list[Path]:
    """Return the prefixes in which packages are looked for: overlays, then AMENT_PREFIX_PATH, then this Python's."""
    sourced = [Path(p) for p in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p]
    return list(dict.fromkeys([*map(Path, overlays), *sourced, Path(sys.prefix)]))


def share_folder(package: str, prefixes: Sequence[Path]) -> Path | None:
    """Return `<prefix>/share/<package>` of the first prefix that has it, or None."""
    return next((s for p in prefixes if (s := p / "share" / package).is_dir()), None)


def interface_packages(prefixes: Sequence[Path]) -> set[str]:
    """Return the names of the packages with interfaces that some prefixes hold."""
    index = Path("share", "ament_index", "resource_index", "rosidl_interfaces")
    return {entry.name for p in prefixes for entry in (p / index).glob("*")}


def package_like(package: str, prefixes: Sequence[Path]) -> str:
    """Return ``did you mean 'x'?`` for a package that isn't there, or an empty string.

    Names end alike (`_msgs`, `_interfaces`), so that they have to be nearer to one another than other words.
    """
    close = get_close_matches(package, interface_packages(prefixes), n=1, cutoff=0.8)
    return f"did you mean {close[0]!r}?" if close else ""


def python_folder(prefix: Path) -> Path | None:
    """Return the folder of a prefix that belongs on `sys.path`, or None when it has none for this Python."""
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    candidates = (
        prefix / "lib" / version / "site-packages",
        prefix / "local" / "lib" / version / "dist-packages",
        prefix / "lib" / version / "dist-packages",
    )
    return next((c for c in candidates if c.is_dir()), None)
