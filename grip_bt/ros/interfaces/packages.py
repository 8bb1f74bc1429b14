"""ROS packages: interface packages on disk, those that are installed, sourced or built here, their programs and use.

Loading every library of a built package by its path is enough: `dlopen("libX.so")`, which ROS does later by bare name,
first looks at the names of the libraries that are already loaded. So an overlay can be added without LD_LIBRARY_PATH
and without a restart; taking one away, or a rebuilt one, needs a new process.
"""

from __future__ import annotations

import ctypes
import importlib
import os
import re
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

from grip_bt.base.errors import DocumentError, GripError, listing, nearest


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
    """Return ``; did you mean 'x'?`` for a package that isn't there, or an empty string."""
    # Names end alike (`_msgs`, `_interfaces`), so they have to be nearer to one another than other words.
    close = get_close_matches(package, sorted(interface_packages(prefixes)), n=1, cutoff=0.8)
    return f"; did you mean {close[0]!r}?" if close else ""


def python_folder(prefix: Path) -> Path | None:
    """Return the folder of a prefix that belongs on `sys.path`, or None when it has none for this Python."""
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    candidates = (
        prefix / "lib" / version / "site-packages",
        prefix / "local" / "lib" / version / "dist-packages",
        prefix / "lib" / version / "dist-packages",
    )
    return next((c for c in candidates if c.is_dir()), None)


class PackageError(GripError):
    """A package, a program of one, or a launch file of one isn't here; it says what is."""


def share_of(package: str) -> Path:
    """Return the `share` folder of a package. Raises PackageError: there is no such package."""
    roots = search_path()
    found = share_folder(package, roots)
    if found is None:
        known = {folder.name for root in roots if (root / "share").is_dir() for folder in (root / "share").iterdir()}
        raise PackageError(
            f"no ROS package {package!r} here{nearest(package, known)}; looked in {', '.join(map(str, roots))}. "
            "Source the workspace that has it (source install/setup.bash), or install it"
        )
    return found


def executable_of(package: str, name: str) -> Path:
    """Return the file of a package's program.

    Raises:
        PackageError: there is no such package, or it has no such program.
    """
    folder = share_of(package).parent.parent / "lib" / package
    file = folder / name
    if file.is_file() and os.access(file, os.X_OK):
        return file
    known = sorted(f.name for f in folder.iterdir() if f.is_file() and os.access(f, os.X_OK)) if folder.is_dir() else []
    has = listing(known)
    raise PackageError(f"{package} has no program {name!r}{nearest(name, known)} in {folder} (available: {has})")


def launch_file_of(package: str, name: str) -> Path:
    """Return a package's launch file, from its `launch/` folder or anywhere in its share.

    Raises:
        PackageError: there is no such package, or it has no such file.
    """
    share = share_of(package)
    return share / "launch" / name if (share / "launch" / name).is_file() else launch_file_in(share, name)


def launch_file_in(folder: Path, name: str) -> Path:
    """Return a launch file by its path in a folder. Raises PackageError: there is none; it says which there are."""
    if (folder / name).is_file():
        return folder / name
    known = sorted(f.relative_to(folder).as_posix() for f in folder.glob("**/*launch*") if f.is_file())
    raise PackageError(f"no launch file {name!r} in {folder}{nearest(name, known)} (available: {listing(known)})")


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
        present = [p for p in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p]
        if str(prefix) not in present:
            os.environ["AMENT_PREFIX_PATH"] = os.pathsep.join([str(prefix), *present])
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


KINDS = ("msg", "srv", "action")
_NAME = re.compile(r"(?!.*__)(?!.*_$)[a-z][a-z0-9_]*")
_WANTED = "an interface package is a folder with package.xml and msg/, srv/ or action/"


@dataclass(frozen=True)
class Package:
    """One ordinary ROS interface package.

    Attributes:
        folder: where package.xml is; absolute.
        files: the .msg, .srv and .action files, relative to `folder`, sorted by kind and name.
        depends: names of the packages that package.xml asks for.
    """

    name: str
    folder: Path
    files: tuple[Path, ...]
    depends: frozenset[str]


def read_package(folder: Path) -> Package:
    """Read one package.

    Raises:
        DocumentError: package.xml isn't there, isn't XML or has no good name, or there is no interface file.
    """
    folder = folder.resolve()
    manifest = folder / "package.xml"
    try:
        root = ElementTree.parse(manifest).getroot()
    except OSError as error:
        raise DocumentError(f"can't be read: {error.strerror}; an interface package has one", str(manifest)) from None
    except ElementTree.ParseError as error:
        line, column = error.position
        raise DocumentError(f"isn't well-formed XML: {error}", str(manifest), line, column + 1) from None
    name = (root.findtext("name") or "").strip()
    if not name:
        raise DocumentError("<name> is missing: the package's name", str(manifest))
    if not _NAME.fullmatch(name):
        raise DocumentError(
            f"<name> is {name!r}: lower case letters, digits and single underscores, a letter first", str(manifest)
        )
    files = tuple(f.relative_to(folder) for kind in KINDS for f in sorted((folder / kind).glob(f"*.{kind}")))
    if not files:
        raise DocumentError("no interface file in msg/, srv/ or action/ beside it", str(manifest))
    depends = {e.text.strip() for e in root if e.tag.endswith("depend") and e.text}
    return Package(name, folder, files, frozenset(depends))


def find_packages(folder: Path) -> list[Package]:
    """Return the interface packages in a folder (itself, or its sub-folders at any depth), dependencies first.

    Raises:
        DocumentError: there is none, two have one name, or they depend on each other in a circle.
    """
    if not folder.is_dir():
        what = "is a file" if folder.exists() else "there is no such folder"
        raise DocumentError(f"{what}; {_WANTED}", str(folder))
    if (folder / "package.xml").is_file():
        return [read_package(folder)]
    packages: dict[str, Package] = {}
    for manifest in sorted(folder.glob("**/package.xml")):
        if not any((manifest.parent / kind).is_dir() for kind in KINDS):
            continue
        package = read_package(manifest.parent)
        if package.name in packages:
            first = packages[package.name].folder
            raise DocumentError(f"the package {package.name!r} is also in {first}", str(manifest))
        packages[package.name] = package
    if not packages:
        lacks = "package.xml is missing" if any((folder / kind).is_dir() for kind in KINDS) else "none is in here"
        raise DocumentError(f"{lacks}; {_WANTED}", str(folder))
    graph = {p.name: sorted(p.depends & packages.keys()) for p in packages.values()}
    try:
        return [packages[name] for name in TopologicalSorter(graph).static_order()]
    except CycleError as error:
        circle = " -> ".join(error.args[1])
        raise DocumentError(f"interface packages depend on each other in a circle: {circle}") from None
