"""Which ROS packages a project's sensors and components need, and which are here: told by files, without ROS."""

from __future__ import annotations

import importlib.util
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from grip_bt.base.errors import DocumentError
from grip_bt.ros.interfaces.ament import (
    PackageError,
    executable_of,
    interface_packages,
    launch_file_of,
    search_path,
    share_folder,
)
from grip_bt.ros.interfaces.build import FOLDER, NEEDS
from grip_bt.task.catalog.component_file import load_component
from grip_bt.task.catalog.component_parts import Start
from grip_bt.task.catalog.project_parts import MISSING, UNFIT, Trouble, missing_package, missing_type

from .folder import Project

KINDS = ("msg", "srv", "action")


class PackagesHere(Mapping[str, frozenset[str]]):
    """Packages with interfaces, and the types of each (`msg/Pose`), which are looked up when somebody asks.

    Args:
        folders: the folders with `msg/`, `srv/` and `action/` of each package.
    """

    def __init__(self, folders: Mapping[str, Sequence[Path]]):
        self._folders = folders
        self._types: dict[str, frozenset[str]] = {}

    def __getitem__(self, package: str) -> frozenset[str]:
        if package not in self._types:
            files = (f for home in self._folders[package] for kind in KINDS for f in (home / kind).glob(f"*.{kind}"))
            self._types[package] = frozenset(f"{f.suffix[1:]}/{f.stem}" for f in files)
        return self._types[package]

    def __iter__(self) -> Iterator[str]:
        return iter(self._folders)

    def __len__(self) -> int:
        return len(self._folders)

    def __contains__(self, package: object) -> bool:
        return package in self._folders


def packages_here(project: Project) -> PackagesHere | None:
    """Return the packages with interfaces that a run would find; None where ROS isn't installed."""
    if importlib.util.find_spec("rclpy") is None:
        return None

    found: dict[str, list[Path]] = {}
    for path in project.folder.glob(f"{project.file.components or 'components'}/*/interfaces/**/package.xml"):
        found.setdefault(_name_in(path), []).append(path.parent)
    for package in interface_packages(search_path()):
        found.setdefault(package, []).extend(prefix / "share" / package for prefix in search_path())
    for package in NEEDS:
        found.setdefault(package, [FOLDER / package])
    return PackagesHere(found)


def sensors_in_need(project: Project, packages: PackagesHere | None) -> dict[str, tuple[Trouble, ...]]:
    """Return, by node, which of the packages aren't here that the project's sensors need."""
    found = {}
    for name, sensor in project.file.sensors.items():
        where, types = f"grip.yaml: sensors/{name}", {topic.message_type() for topic in sensor.topics.values()}
        found[f"sensor/{name}"] = (
            *_lacking(types, packages, where, True),
            *_unstartable(sensor.driver, packages, where),
        )
    return found


def components_in_need(project: Project, packages: PackagesHere | None) -> dict[str, tuple[Trouble, ...]]:
    """Return likewise for its components, and what is wrong with their files."""
    found: dict[str, tuple[Trouble, ...]] = {}
    for name, folder in project.component_folders().items():
        where = f"components/{name}/component.yaml"
        try:
            file = load_component(folder)
        except DocumentError as error:
            said = f"{where}: a run refuses this component: {error}"
            found[f"component/{name}"] = (Trouble(UNFIT, said, "mend the file, and `grip component add` it again"),)
            continue
        lacking = (*_lacking({file.interface}, packages, where), *_unstartable(file.start, packages, where))
        troubles = (*_misplaced(name, file.name, where), *lacking)
        found[f"component/{file.name}"] = troubles
    return found


def _misplaced(folder: str, name: str, where: str) -> list[Trouble]:
    """Return that a component lies in a folder of another name than its own, under which a run looks for it."""
    if folder == name:
        return []
    said = f"{where}: the component is called {name!r}, and its folder {folder!r}, so that a run doesn't find it"
    return [Trouble(UNFIT, said, f"rename the folder to {name!r}, or write `name: {folder}` and add it again")]


def _lacking(types: Iterable[str], packages: PackagesHere | None, where: str, messages: bool = False) -> list[Trouble]:
    if packages is None:
        return []
    found = (missing_type(type_, packages, where, messages) for type_ in sorted(types) if "/" in type_)
    return list(dict.fromkeys(trouble for trouble in found if trouble is not None))


def _unstartable(start: Start | None, packages: PackagesHere | None, where: str) -> list[Trouble]:
    """Return that the package of the program to start isn't installed; it need not have interfaces."""
    if packages is None or start is None or not start.run or start.package is None:
        return []
    if share_folder(start.package, search_path()) is None:
        return [missing_package(start.package, packages, where)]
    try:
        if start.executable is not None:
            executable_of(start.package, start.executable)
        elif start.launch is not None:
            launch_file_of(start.package, start.launch)
    except PackageError as error:
        return [Trouble(MISSING, f"{where}: {error}", "name one that it has")]
    return []


def _name_in(manifest: Path) -> str:
    try:
        return ET.parse(manifest).getroot().findtext("name", "").strip()
    except (ET.ParseError, OSError):
        return manifest.parent.name
