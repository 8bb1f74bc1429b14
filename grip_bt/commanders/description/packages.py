"""Where `package://NAME/...` and `$(find NAME)` lie: given folders, the workspace around them, ROS's, Python's.

Nothing is imported, and no ROS has to be there. The files of ready-made robots are named here, too.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType

from grip_bt.base.errors import MissingPartError

OWN = Path(__file__).parents[2]
"""GRIP's own folder, which has the files of ready-made robots."""
SCHEMES = ("package://", "model://")
MANIFEST = "package.xml"
_NAME = re.compile(r"<name>\s*([^<\s]+)\s*</name>")
_BUILT = frozenset(("build", "install", "log", "devel", "node_modules", "__pycache__"))
_MOST, _HIGHEST = 20_000, 8
"""Folders that are looked into below one, and how far up a workspace's `src` is looked for."""


def name_of_package(folder: Path) -> str:
    """Return the name in a folder's `package.xml`, or empty."""
    try:
        found = _NAME.search((folder / MANIFEST).read_text(encoding="utf-8", errors="replace"))
    except OSError:
        return ""
    return found.group(1) if found else folder.name


def package_around(path: Path) -> Path | None:
    """Return the package that a file or folder lies in, if any."""
    return next((f for f in (path, *path.parents) if (f / MANIFEST).is_file()), None)


def packages_below(root: Path) -> Iterator[tuple[str, Path]]:
    """Yield the name and folder of each package, the least deep first; as colcon, nothing is looked for within one."""
    level, seen = [root], 0
    while level and seen < _MOST:
        inner: list[Path] = []
        for folder in level:
            seen += 1
            if name := name_of_package(folder):
                yield name, folder
            else:
                inner += _folders_in(folder)
        level = inner


def _folders_in(folder: Path) -> list[Path]:
    try:
        with os.scandir(folder) as entries:
            names = [e.name for e in entries if e.is_dir(follow_symlinks=False)]
    except OSError:
        return []
    return [folder / name for name in sorted(names) if name not in _BUILT and not name.startswith(".")]


def surroundings(package: Path) -> list[Path]:
    """Return the folders that a package's companions lie below, nearest first.

    They go up to the workspace's `src`, else to where its repository stands beside others, else no further than its own
    folder's. What pip has installed has none.
    """
    above = [] if "site-packages" in package.parts else list(package.parents)[:_HIGHEST]
    top = max((k for k, folder in enumerate(above) if folder.name == "src"), default=None)
    if top is None:
        top = next((k for k, folder in enumerate((package, *above)) if (folder / ".git").exists()), 0)
    return above[: top + 1]


class Packages:
    """Finds packages by name.

    Args:
        given: package name -> folder; these come first.
        near: files of the robot; the package that one of them lies in is known by its name.
    """

    def __init__(self, given: Mapping[str, Path] | None = None, near: tuple[Path, ...] = ()):
        self.given = {name: Path(folder).resolve() for name, folder in (given or {}).items()}
        for path in near:
            if (folder := package_around(path.resolve())) is not None:
                self.given.setdefault(name_of_package(folder), folder)
        self._below: dict[Path, dict[str, Path]] = {}

    def find(self, name: str) -> Path:
        """Return a package's folder. Raises MissingPartError: there is no such package."""
        if name == OWN.name:  # in a checkout, too, whose package.xml has the name and lies one folder higher
            return OWN
        if name in self.given:
            return self.given[name]
        if name and (there := self._in_workspace(name) or _in_ros(name) or _installed(name)) is not None:
            return there
        known = ", ".join(sorted(self.given)) or "none"
        raise MissingPartError(
            f"package {name!r}",
            f"name its folder under `packages:` (given: {known}), source its ROS workspace or install it with pip",
        )

    def known(self, name: str) -> Path | None:
        """Return a package's folder; None where there is no such package."""
        try:
            return self.find(name)
        except MissingPartError:
            return None

    def _in_workspace(self, name: str) -> Path | None:
        for package in dict.fromkeys(self.given.values()):
            for root in surroundings(package):
                if root not in self._below:
                    self._below[root] = {}
                    for known, folder in packages_below(root):
                        self._below[root].setdefault(known, folder)
                if name in self._below[root]:
                    return self._below[root][name]
        return None

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
            if (folder / "package.xml").is_file():
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


ROBOTS: Mapping[str, Path] = MappingProxyType(
    {file.stem: file for file in sorted((Path(__file__).parents[1] / "robots").glob("*.yaml"))}
)
"""Ready-made robot -> its file, which holds what `robot:` in a project file may hold. A new robot is a new file."""
