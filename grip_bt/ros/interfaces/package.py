"""Interface packages on disk: found, read from `package.xml`, ordered by what they depend on."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

from grip_bt.base.errors import DocumentError

KINDS = ("msg", "srv", "action")
_NAME = re.compile(r"(?!.*__)(?!.*_$)[a-z][a-z0-9_]*")
_WANTED = "an interface package is a folder with package.xml and msg/, srv/ or action/"


@dataclass(frozen=True)
class Package:
    """One ordinary ROS interface package.

    Attributes:
        name: its name in package.xml.
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
    return in_dependency_order(packages.values())


def in_dependency_order(packages: Iterable[Package]) -> list[Package]:
    """Return the packages so that each comes after those that it needs.

    Raises:
        DocumentError: they depend on each other in a circle.
    """
    by_name = {p.name: p for p in packages}
    graph = {p.name: sorted(p.depends & by_name.keys()) for p in by_name.values()}
    try:
        return [by_name[name] for name in TopologicalSorter(graph).static_order()]
    except CycleError as error:
        circle = " -> ".join(error.args[1])
        raise DocumentError(f"interface packages depend on each other in a circle: {circle}") from None
