"""One robot from its own files; xacro files are expanded by the `xacro` package in a process with limits."""

from __future__ import annotations

import json
import subprocess
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from grip_bt.base.errors import DocumentError, UnknownNameError, nearest
from grip_bt.base.interpreter import python_command
from grip_bt.commanders.description.build import build, normal, with_config, with_states
from grip_bt.commanders.description.check_urdf import check_urdf
from grip_bt.commanders.description.config import RobotConfig
from grip_bt.commanders.description.files import Finding, errors, finding_of, note
from grip_bt.commanders.description.mjcf import excluded_pairs, urdf_of_mjcf
from grip_bt.commanders.description.moveit_files import JointLimits
from grip_bt.commanders.description.moveit_package import MoveItPackage, preferences_of, read_package
from grip_bt.commanders.description.packages import Packages
from grip_bt.commanders.description.robot import RobotDescription
from grip_bt.commanders.description.srdf import Srdf, check_srdf, read_srdf, with_known_ends
from grip_bt.commanders.description.tree import Tree
from grip_bt.commanders.description.xml import Element, parse_xml, read_xml
from grip_bt.commanders.settings import PLANNERS

TIME = 30.0
"""After so long a file won't end any more [s]; large robots take one or two."""
MODULE = "grip_bt.commanders.description.xacro_process"


def expand(path: Path, arguments: Mapping[str, object], packages: Packages) -> str:
    """Return a xacro file's XML.

    Args:
        arguments: values for its `<xacro:arg>`s; those that it doesn't declare are passed too, for files it includes.
        packages: for `$(find NAME)`.

    Raises:
        DocumentError: it can't be expanded; the message is xacro's own.
    """
    if not path.is_file():
        raise DocumentError("there is no such file", str(path))
    request = {
        "file": str(path.absolute()),
        "arguments": {
            name: str(value).lower() if isinstance(value, bool) else str(value) for name, value in arguments.items()
        },
        "packages": {name: str(folder) for name, folder in packages.given.items()},
    }
    try:
        done = subprocess.run(
            python_command("-m", MODULE), input=json.dumps(request), capture_output=True, text=True, timeout=TIME
        )
        reply = json.loads(done.stdout)
    except subprocess.TimeoutExpired:
        raise DocumentError(f"xacro doesn't end: it was stopped after {TIME:g} s", str(path)) from None
    except json.JSONDecodeError:
        raise DocumentError("xacro ended without a result: it took too much time or memory", str(path)) from None
    if "error" in reply:
        raise DocumentError(f"xacro: {reply['error']}", str(path))
    note(*map(Path, reply["files"]))
    return str(reply["text"])


def expanded(path: Path, arguments: Mapping[str, object], packages: Packages, root: str = "robot") -> Element:
    """Return a xacro file as its tree; lines are those of the expanded text.

    Raises:
        DocumentError: it can't be expanded, or gives something else.
    """
    return parse_xml(expand(path, arguments, packages), root, str(path))


def declared_arguments(path: Path) -> tuple[str, ...]:
    """Return the names of the arguments that a xacro file declares itself, in order."""
    names = (e.get("name", "") for e in read_xml(path, "robot").iter("xacro:arg"))
    return tuple(dict.fromkeys(filter(None, names)))


@dataclass(frozen=True)
class Inspected:
    """A robot with everything that was found about it.

    Attributes:
        findings: errors and warnings of all its files.
        description: the robot; None where a finding is an error.
        packages: the MoveIt configuration packages that it was read from.
    """

    findings: tuple[Finding, ...]
    description: RobotDescription | None = None
    packages: tuple[MoveItPackage, ...] = ()


def load_single(config: RobotConfig, folder: Path) -> Inspected:
    """Return a robot from its own files.

    Args:
        config: with a `urdf`, `xacro`, `mjcf` or `moveit`.
        folder: that relative paths begin in.
    """
    single = _Single(config, folder)
    try:
        return single.loaded()
    except DocumentError as error:
        return Inspected((*single.findings, finding_of(error)))


class _Single:
    def __init__(self, config: RobotConfig, folder: Path):
        self.config, self.folder = config, folder
        self.findings: list[Finding] = []
        given = {name: folder / Path(place).expanduser() for name, place in config.packages.items()}
        self.packages = Packages(given)
        files = (config.urdf, config.xacro, config.srdf, config.moveit and f"{config.moveit}/package.xml")
        self.packages = Packages(given, tuple(self._path(file) for file in files if file))
        self.moveit: MoveItPackage | None = None

    def loaded(self) -> Inspected:
        if self.config.moveit is not None:
            self.moveit = read_package(self._path(self.config.moveit), self.packages)
            self.findings += self.moveit.findings
        robot, source = self._urdf()
        self.findings += check_urdf(robot, str(source), self.packages)
        description = None if self._wrong() else self._described(robot, source)
        packages = (self.moveit,) if self.moveit is not None else ()
        return Inspected(tuple(self.findings), None if self._wrong() else description, packages)

    def _described(self, robot: ET.Element, source: Path) -> RobotDescription | None:
        tree = Tree(robot)
        known, told = with_known_ends(self._srdf())
        self.findings += told
        srdf = with_config(known, self.config)
        self.findings += check_srdf(srdf, tree)
        if self._wrong():
            return None
        try:
            added = with_states(srdf, self.config, tree)
        except (DocumentError, UnknownNameError) as error:
            self.findings.append(Finding("error", "bad-state", getattr(error, "message", str(error))))
            return None
        self.findings += [f for f in check_srdf(added, tree) if f not in self.findings]
        limits = self.moveit.limits if self.moveit is not None else {}
        initial = self.moveit.initial_positions if self.moveit is not None else {}
        self.findings += _check_names(self.config, tree, added, limits, initial)
        self.findings += _check_limits(limits, tree)
        if self._wrong():
            return None
        name = self.config.name or robot.get("name") or "robot"
        urdf = normal(robot, name, source.parent, self.packages, limits)
        made = build(urdf, added, self.config, limits, initial)
        preferences = {} if self.moveit is None else preferences_of(self.moveit, made.groups, PLANNERS)
        return replace(made, preferences=preferences)

    def _urdf(self) -> tuple[ET.Element, Path]:
        config = self.config
        if config.mjcf is not None:
            path = self._path(config.mjcf)
            return urdf_of_mjcf(path), path
        word = config.urdf or config.xacro
        arguments: Mapping[str, object] = config.arguments
        if word is not None:
            path = self._path(word)
        elif self.moveit is not None and self.moveit.urdf is not None:
            path, arguments = self.moveit.urdf, {**self.moveit.arguments, **config.arguments}
        else:
            raise DocumentError("no URDF is given; name it as `urdf:` or `xacro:`", str(self.folder))
        if config.xacro is None and path.suffix != ".xacro":
            if config.arguments:
                self._warn("unused-arguments", "arguments are for xacro files; this URDF takes none", path)
            return read_xml(path, "robot"), path
        self._check_arguments(path)
        return expanded(path, arguments, self.packages), path

    def _srdf(self) -> Srdf:
        path = None if self.config.srdf is None else self._path(self.config.srdf)
        if path is None and self.moveit is not None:
            path = self.moveit.srdf
        if path is None:
            if not self.config.groups:
                self._warn("no-groups", "there is no SRDF and no `groups:`; nothing can be planned", None)
            mjcf = self.config.mjcf
            return Srdf() if mjcf is None else Srdf(disabled=excluded_pairs(self._path(mjcf)))
        if path.suffix == ".xacro":
            return read_srdf(expanded(path, self.config.arguments, self.packages), str(path))
        return read_srdf(read_xml(path, "robot"), str(path))

    def _check_arguments(self, path: Path) -> None:
        declared = declared_arguments(path) if path.is_file() else ()
        for name in self.config.arguments:
            if name not in declared:
                self._warn(
                    "unknown-argument",
                    f"the file declares no argument {name!r}{nearest(name, declared)} (it declares: "
                    f"{', '.join(declared) or 'none'}); only a file that it includes can use it",
                    path,
                )

    def _path(self, word: str) -> Path:
        return self.packages.resolve(word, self.folder) if "://" in word else (self.folder / Path(word).expanduser())

    def _wrong(self) -> bool:
        return bool(errors(self.findings))

    def _warn(self, code: str, message: str, path: Path | None) -> None:
        self.findings.append(Finding("warning", code, message, "" if path is None else str(path)))


def _check_names(
    config: RobotConfig, tree: Tree, srdf: Srdf, limits: Mapping[str, JointLimits], initial: Mapping[str, float]
) -> Iterator[Finding]:
    """Yield what a configuration and a MoveIt package name that isn't there."""

    def unknown(kind: str, name: str, allowed: object, where: str, severity: str = "error") -> Iterator[Finding]:
        names = list(allowed)  # type: ignore[call-overload]
        if name not in names:
            message = f"{where}: there is no {kind} {name!r}{nearest(name, names)}"
            yield Finding(severity, f"unknown-{kind}", message)  # type: ignore[arg-type]

    for group, frame in config.grasp_frames.items():
        yield from unknown("group", group, srdf.groups, "grasp_frames")
        yield from unknown("link", frame.link, tree.links, f"grasp_frames/{group}")
    for group, fingers in config.fingers.items():
        yield from unknown("group", group, srdf.groups, "fingers")
        for finger, links in fingers.items():
            for link in links:
                yield from unknown("link", link, tree.links, f"fingers/{group}/{finger}")
    for group in config.drives:
        yield from unknown("group", group, srdf.groups, "drives")
    for name in config.accelerations:
        yield from unknown("joint", name, [*srdf.groups, *tree.joints], "accelerations")
    for where, joints in (("joint_limits.yaml", limits), ("initial_positions.yaml", initial)):
        for name in joints:
            yield from unknown("joint", name, tree.joints, where, "warning")


def _check_limits(limits: Mapping[str, JointLimits], tree: Tree) -> Iterator[Finding]:
    for name, limit in limits.items():
        joint = tree.joints.get(name)
        if joint is None or joint.type not in ("revolute", "prismatic"):
            continue
        lower = joint.lower if limit.lower is None else limit.lower
        upper = joint.upper if limit.upper is None else limit.upper
        if not lower < upper or (limit.velocity is not None and limit.velocity <= 0):
            yield Finding(
                "error",
                "missing-limit",
                f"joint_limits.yaml: joint {name!r} can't move: positions {lower:g} ... {upper:g}, velocity "
                f"{joint.velocity if limit.velocity is None else limit.velocity:g}",
            )
