"""Which configurations a MoveIt or description package holds, and which URDF goes with which SRDF.

Packages leave it to launch files to say which of their files go together: `fitted` tries those that the package, its
launch files and the packages that it depends on have, and takes the first that has all that the SRDF names.
"""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from difflib import SequenceMatcher
from pathlib import Path

from grip_bt.base.errors import DocumentError

from .files import read_yaml
from .hints import Declared, Hints, declared, hints_of
from .packages import MANIFEST, Packages, packages_below, surroundings
from .xml import read_robot

ASSISTANT = ".setup_assistant"
TRIES = 10
"""URDFs that are expanded in search of the one that fits."""
LEAST = 0.5
"""Part of an SRDF's names that has to be in its URDF."""
Arguments = Mapping[str, object]


@dataclass(frozen=True)
class Alternative:
    """A configuration that can be chosen.

    Attributes:
        name: what tells it from the others of its package.
        srdf: its SRDF or the xacro of it; None for a URDF alone.
        arguments: of the xacro files.
        urdf: its URDF or xacro, where that is known.
    """

    name: str
    srdf: Path | None
    arguments: Arguments = field(default_factory=dict)
    urdf: Path | None = None


@dataclass(frozen=True)
class Fitted(Alternative):
    """An alternative with its URDF.

    Attributes:
        robot: the URDF's tree.
        semantic: the SRDF's tree, or None.
        fit: part of the names in the SRDF that are in the URDF.
    """

    robot: ET.Element = field(default_factory=lambda: ET.Element("robot"))
    semantic: ET.Element | None = None
    fit: float = 1.0


class Configurations:
    """The configurations of a package.

    Args:
        folder: the package.
        packages: where others are looked for.
        hints: of its launch files, where they aren't those of the package.
    """

    def __init__(self, folder: Path, packages: Packages, hints: Hints | None = None):
        self.folder, self.packages = folder, packages
        self.hints = hints or hints_of(folder)
        self.assistant = _assistant(folder)
        self._declared: dict[Path, Declared] = {}

    def alternatives(self) -> list[Alternative]:
        """Return what can be chosen, the most likely first; URDFs alone where there is no SRDF."""
        found = [Alternative(_stem(path), path) for path in self._srdfs()]
        if not found:
            found = [Alternative(_stem(path), None, urdf=path) for path in self._urdfs(_stem(self.folder))[:TRIES]]
        if len(found) == 1 and (varied := self._varied(found[0])):
            return varied
        return found

    def _varied(self, only: Alternative) -> list[Alternative]:
        """Return an alternative for each value of the argument that tells robots of one file apart."""
        files = [p for p in (only.srdf, only.urdf or next(iter(self._urdfs(only.name)), None)) if p is not None]
        for path in files:
            told = self._told(path)
            for name in told.arguments:
                values = self.hints.choices.get(name) or told.choices.get(name) or []
                if len(values) > 1 and not {v.lower() for v in values} <= {"true", "false"}:
                    default = told.arguments[name]
                    first = [v for v in values if v == default]
                    return [
                        replace(only, name=value, arguments={name: value})
                        for value in [*first, *(v for v in values if v != default)]
                    ]
        return []

    def fitted(self, chosen: Alternative) -> Fitted:
        """Return an alternative with the URDF that fits it best. Raises DocumentError: none does."""
        best: Fitted | None = None
        failed: DocumentError | None = None
        candidates = [chosen.urdf] if chosen.urdf is not None else self._urdfs(chosen.name)[:TRIES]
        for urdf in candidates:
            for hinted in (True, False):
                try:
                    found = self._with(chosen, urdf, hinted)
                except DocumentError as error:
                    failed = failed or (error if best is None else None)
                    continue
                if best is None or found.fit > best.fit:
                    best = found
                if best.fit == 1 or chosen.srdf is None:
                    return best
        if best is not None and best.fit >= LEAST:
            return best
        if failed is not None:
            raise DocumentError(f"{failed.message} (the URDF that is the likeliest)", failed.source, failed.line)
        tried = ", ".join(path.name for path in candidates) or "none found"
        entry = self.assistant.get("urdf", {})
        named = "/".join(str(entry[key]) for key in ("package", "relative_path") if entry.get(key))
        asked = f"{ASSISTANT} names {named}; " if named else ""
        raise DocumentError(
            f"no URDF has what the SRDF names ({asked}tried: {tried}); name it as `urdf:` or `xacro:`",
            str(chosen.srdf or self.folder),
        )

    def _with(self, chosen: Alternative, urdf: Path, hinted: bool) -> Fitted:
        arguments: dict[str, object] = dict(chosen.arguments)
        files = [path for path in (chosen.srdf, urdf) if path is not None and path.suffix == ".xacro"]
        for path in files:
            for name, default in self._told(path).arguments.items():
                if name not in arguments and (value := self._value(name, default, path, chosen, hinted)) is not None:
                    arguments[name] = value
        robot = self._read(urdf, arguments, chosen, hinted)
        semantic = None if chosen.srdf is None else self._read(chosen.srdf, arguments, chosen, hinted)
        fit = 1.0 if semantic is None else _fit(semantic, robot)
        return Fitted(chosen.name, chosen.srdf, arguments, urdf, robot, semantic, fit)

    def _read(self, path: Path, arguments: dict[str, object], chosen: Alternative, hinted: bool) -> ET.Element:
        """Expand a file; arguments that only files which it includes need are found by what xacro misses."""
        while True:
            try:
                return read_robot(path, arguments, self.packages)
            except DocumentError as error:
                missed = _UNDEFINED.search(error.message)
                if missed is None or missed.group(1) in arguments:
                    raise
                arguments[missed.group(1)] = self._value(missed.group(1), None, path, chosen, hinted) or ""

    def _value(self, name: str, default: str | None, path: Path, chosen: Alternative, hinted: bool) -> str | None:
        """Return what an argument is given; None for its default."""
        hints = self.hints if hinted else Hints()
        given = hints.given.get(name, [])
        possible = hints.choices.get(name) or self._told(path).choices.get(name) or []
        if possible and default not in possible:
            return _nearest(chosen.name, possible)
        if len(given) == 1 or (given and default not in given):
            return given[0]
        if default is not None:
            return None
        if value := self.hints.defaults.get(name):
            return value
        return chosen.name if name in _NAMES else "0.0.0.0" if name.endswith("ip") else ""

    def _told(self, path: Path) -> Declared:
        if path not in self._declared:
            self._declared[path] = declared(path, self.packages)
        return self._declared[path]

    def _srdfs(self) -> list[Path]:
        named = str(self.assistant.get("srdf", {}).get("relative_path") or "")
        found = [path for path in _files_below(self.folder, _is_srdf) if self._told(path).whole]

        def order(path: Path) -> tuple[bool, int, int, int, str]:
            mentioned = self.hints.files.index(path.name) if path.name in self.hints.files else len(self.hints.files)
            groups = path.read_bytes().count(b"<group ")  # a robot with its hand before the same one without
            return path != self.folder / named, mentioned, len(path.parts), -groups, path.name

        return sorted(found, key=order)

    def _urdfs(self, name: str) -> list[Path]:
        """Return the URDFs that there may be for a configuration, the likeliest first."""
        certain: list[Path] = []
        entry = self.assistant.get("urdf", {})
        if relative := str(entry.get("relative_path") or ""):
            package = str(entry.get("package") or "")
            home = self.packages.known(package) if package else self.folder
            certain = [] if home is None else [home / relative]
        own = sorted(p for p in _files_below(self.folder, _is_urdf) if self._told(p).whole)
        others = [p for folder in self._described() for p in _files_below(folder, _is_urdf) if self._told(p).whole]
        mentioned = set(self.hints.files)

        def order(path: Path) -> tuple[bool, float]:
            return path.name not in mentioned, -_likeness(name, _stem(path))

        in_config = sorted((p for p in own if p.parent.name == "config"), key=order)
        rest = sorted((p for p in [*own, *others] if p not in in_config), key=order)
        return [p for p in dict.fromkeys([*in_config, *certain, *rest]) if p.is_file()]

    def _described(self) -> Iterator[Path]:
        """Yield the packages that may hold the URDF: those that are named, then those beside that sound like it."""
        entry = self.assistant.get("urdf", {})
        manifest = self.folder / MANIFEST
        depends = _DEPENDS.findall(manifest.read_text(errors="replace")) if manifest.is_file() else []
        seen = {self.folder}
        for name in dict.fromkeys([str(entry.get("package") or ""), *self.hints.packages, *depends]):
            folder = self.packages.known(name) if name else self.folder
            if folder is not None and folder not in seen and not name.startswith("moveit_ros"):
                seen.add(folder)
                yield folder
        for root in surroundings(self.folder)[:2]:
            for name, folder in packages_below(root):
                if folder not in seen and _SOUNDS.search(name):
                    seen.add(folder)
                    yield folder


_UNDEFINED = re.compile(r"Undefined substitution argument (\w+)")
_TESTS = frozenset({"test", "tests"})
_DEPENDS = re.compile(r"<(?:exec_|run_|build_)?depend\b[^>]*>\s*([\w-]+)\s*<")
_SOUNDS = re.compile(r"description|support|urdf|model|robot")
_NAMES = ("name", "robot_name", "robot_model", "robot", "model", "robot_type", "arm_id")


def is_configured(folder: Path) -> bool:
    """Tell whether a folder is a MoveIt configuration package: it has a `.setup_assistant`, or an SRDF somewhere."""
    return (folder / ASSISTANT).is_file() or next(iter(_files_below(folder, _is_srdf)), None) is not None


def configured_packages(root: Path) -> list[Path]:
    """Return the MoveIt configuration packages that a folder, such as a workspace, holds; else itself if it is one."""
    found = [folder for _, folder in packages_below(root) if is_configured(folder)]
    return found or [root] * is_configured(root)


def _is_srdf(path: Path) -> bool:
    return path.name.endswith((".srdf", ".srdf.xacro"))


def _is_urdf(path: Path) -> bool:
    return path.name.endswith((".urdf", ".xacro")) and ".srdf" not in path.name and "srdf" not in path.parts[-3:]


def _files_below(folder: Path, wanted: Callable[[Path], bool]) -> list[Path]:
    found = (p for pattern in ("*.srdf", "*.urdf", "*.xacro") for p in folder.rglob(pattern))
    return sorted(p for p in found if wanted(p) and p.is_file() and _TESTS.isdisjoint(p.relative_to(folder).parts))


def _assistant(folder: Path) -> Mapping[str, Mapping[str, object]]:
    path = folder / ASSISTANT
    try:
        data = read_yaml(path) if path.is_file() else {}
    except DocumentError:
        return {}
    entry = data.get("moveit_setup_assistant_config", {})
    # ROS 1 writes `URDF:` and `SRDF:`, ROS 2 `urdf:` and `srdf:`
    return {str(k).lower(): v for k, v in entry.items() if isinstance(v, dict)} if isinstance(entry, dict) else {}


def _stem(path: Path) -> str:
    return path.name.split(".")[0].removesuffix("_moveit_config").removesuffix("_description")


def _likeness(one: str, other: str) -> float:
    return SequenceMatcher(None, one.lower(), other.lower()).ratio()


def _nearest(name: str, values: list[str]) -> str:
    return max(values, key=lambda value: _likeness(name, value) if value in name or name in value else 0.0)


def _fit(semantic: ET.Element, robot: ET.Element) -> float:
    """Return the part of the links and joints in an SRDF's groups, states and ends that a URDF has."""
    there = {e.get("name") for tag in ("link", "joint") for e in robot.findall(tag)}
    virtual = {e.get("name") for e in semantic.findall("virtual_joint")}
    asked: list[str | None] = []
    for group in semantic.findall("group"):
        asked += [e.get("name") for tag in ("link", "joint") for e in group.findall(tag)]
        asked += [e.get(end) for e in group.findall("chain") for end in ("base_link", "tip_link")]
    asked += [e.get("parent_link") for e in semantic.findall("end_effector")]
    asked += [e.get("name") for e in semantic.iterfind("group_state/joint")]
    asked = [name for name in asked if name not in virtual]
    return sum(name in there for name in asked) / len(asked) if asked else 0.0
