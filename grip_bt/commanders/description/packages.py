"""Where `package://NAME/...` and `$(find NAME)` lie: given folders, packages beside them, ROS's, Python's.

Nothing is imported, and no ROS has to be there. The files of ready-made robots are named here, too.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType

from grip_bt.base.errors import DocumentError, MissingPartError
from grip_bt.commanders.description.xml import read_xml

SCHEMES = ("package://", "model://")


class Packages:
    """Finds packages by name.

    Args:
        given: package name -> folder; these come first.
        near: files of the robot; the package that one of them lies in is known by its name.
    """

    def __init__(self, given: Mapping[str, Path] | None = None, near: tuple[Path, ...] = ()):
        self.given = {name: Path(folder).resolve() for name, folder in (given or {}).items()}
        for path in near:
            for folder in path.resolve().parents:
                if (folder / "package.xml").is_file():
                    self.given.setdefault(_name_in(folder / "package.xml") or folder.name, folder)
                    break

    def find(self, name: str) -> Path:
        """Return a package's folder.

        Raises:
            MissingPartError: there is no such package.
        """
        if name in self.given:
            return self.given[name]
        for folder in self.given.values():  # as in a workspace's src/
            if name and (folder.parent / name / "package.xml").is_file():
                return folder.parent / name
        for place in _PLACES:
            if (found := place(name)) is not None:
                return found
        known = ", ".join(sorted(self.given)) or "none"
        raise MissingPartError(
            f"package {name!r}",
            f"name its folder under `packages:` (given: {known}), source its ROS workspace or install it with pip",
        )

    def resolve(self, uri: str, beside: Path) -> Path:
        """Return the file that a URI or path names; `beside` is the folder that relative paths start in.

        Raises:
            MissingPartError: its package isn't known.
        """
        for scheme in SCHEMES:
            if uri.startswith(scheme):
                package, _, rest = uri.removeprefix(scheme).partition("/")
                return self.find(package) / rest
        return (beside / uri.removeprefix("file://")).resolve()


def _in_ros(name: str) -> Path | None:
    for variable, below in (("AMENT_PREFIX_PATH", "share"), ("ROS_PACKAGE_PATH", "")):
        for prefix in filter(None, os.environ.get(variable, "").split(os.pathsep)):
            folder = Path(prefix) / below / name
            if name and (folder / "package.xml").is_file():
                return folder
    return None


@cache
def _installed(name: str) -> Path | None:
    """Return the folder of a Python module of that name, or of data in a distribution of that name."""
    try:
        spec = find_spec(name) if name.isidentifier() else None
    except (ImportError, ValueError, AttributeError):
        spec = None
    if spec is not None and spec.submodule_search_locations:
        return Path(next(iter(spec.submodule_search_locations)))
    try:
        files = distribution(name).files or []
    except (PackageNotFoundError, ValueError):
        return None
    manifest = next((f for f in files if str(f).endswith(f"{name}/package.xml")), None)
    return Path(str(manifest.locate())).resolve().parent if manifest is not None else None


_PLACES: tuple[Callable[[str], Path | None], ...] = (_in_ros, _installed)


def _name_in(manifest: Path) -> str:
    try:
        return (read_xml(manifest, "package").findtext("name") or "").strip()
    except DocumentError:
        return ""


ROBOTS: Mapping[str, Path] = MappingProxyType(
    {file.stem: file for file in sorted((Path(__file__).parents[1] / "robots").glob("*.yaml"))}
)
"""Ready-made robot -> its file, which holds what `robot:` in a project file may hold. A new robot is a new file."""
EXTRAS: Mapping[str, str] = MappingProxyType({"example-robot-data": "motion"})
"""Package with models of ready-made robots -> our extra that brings it."""
