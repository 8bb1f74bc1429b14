"""Interface packages that aren't on PyPI, written here from their documented fields, and built when they are needed.

What is installed, sourced or built by the user comes first. Type hashes are equal to those of the releases named in
`docs/launching.md`, as far as they are documented; a server of another release is refused by the preflight.
"""

from __future__ import annotations

import importlib.util
import threading
from pathlib import Path

from grip_bt.base.errors import UnknownNameError

FOLDER = Path(__file__).parents[1] / "definitions"
NEEDS: dict[str, tuple[str, ...]] = {
    "grip_msgs": (),
    "control_msgs": (),
    "controller_manager_msgs": (),
    "tf2_msgs": (),
    "octomap_msgs": (),
    "object_recognition_msgs": (),
    "moveit_msgs": ("object_recognition_msgs", "octomap_msgs"),
}
"""Packages that are written here, and which of them each needs."""
_lock = threading.Lock()
_provided: dict[str, list[Path]] = {}


def provide(package: str, cache: Path | None = None) -> list[Path]:
    """Make a package importable: as it is installed, else built from its definition, which takes some seconds once.

    Args:
        package: one of `NEEDS`.
        cache: where built packages are kept; the user's cache by default.

    Returns:
        the prefixes that were built, for processes that need it too; none when the package is installed.

    Raises:
        UnknownNameError: there is no such definition.
        MissingPartError: no compiler, or no generators.
        InterfaceBuildError: the compiler failed.
    """
    from . import build_interfaces
    from .ament import activate

    if package not in NEEDS:
        raise UnknownNameError("interface definition", package, NEEDS)
    with _lock:
        if package in _provided:
            return list(_provided[package])
        if importlib.util.find_spec(package) is not None:
            return []
        prefixes: list[Path] = []
        for name in (*NEEDS[package], package):
            if name in _provided:
                prefixes = [*_provided[name], *prefixes]
            elif importlib.util.find_spec(name) is None:
                (built,) = build_interfaces(FOLDER / name, cache, prefixes)
                activate(built.prefix)
                prefixes.insert(0, built.prefix)
        _provided[package] = prefixes
        return list(prefixes)
