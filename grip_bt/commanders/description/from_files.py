"""One robot from its own files, with all that is found about them."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from grip_bt.base.errors import DocumentError, listing, nearest
from grip_bt.base.issue import Issue
from grip_bt.commanders.settings import PLANNERS

from .build import build, normal, with_config, with_states
from .check_urdf import check_urdf
from .config import RobotConfig
from .configurations import Alternative, Configurations, Fitted, configured_packages
from .files import errors, finding_of, robot_issue
from .guessed import with_efforts, with_groups, with_postures
from .hints import declared
from .moveit_package import JointLimits, MoveItPackage, preferences_of, read_package
from .packages import MANIFEST, Packages
from .robot import RobotDescription
from .srdf import Srdf, read_srdf, with_known_names
from .tree import Tree
from .xml import read_robot


@dataclass(frozen=True)
class Inspected:
    """A robot with everything that was found about it.

    Attributes:
        findings: errors and warnings of all its files.
        description: the robot; None where a finding is an error.
        packages: the MoveIt configuration packages that it was read from.
        chosen: of a MoveIt configuration package, the configuration that was taken.
    """

    findings: tuple[Issue, ...]
    description: RobotDescription | None = None
    packages: tuple[MoveItPackage, ...] = ()
    chosen: Fitted | None = None


def load_single(config: RobotConfig, folder: Path) -> Inspected:
    """Return a robot from its own files.

    Args:
        config: with a `urdf`, `xacro` or `moveit`.
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
        self.findings: list[Issue] = []
        given = {name: folder / Path(place).expanduser() for name, place in config.packages.items()}
        self.packages = Packages(given, (folder,))
        files = (config.urdf, config.xacro, config.srdf, config.moveit and f"{config.moveit}/package.xml")
        self.packages = Packages(given, tuple(self._path(file) for file in files if file))
        self.moveit = MoveItPackage(folder)  # of which nothing is said
        self.chosen: Fitted | None = None

    def loaded(self) -> Inspected:
        if self.config.moveit is not None:
            self._choose(self._path(self.config.moveit))
        robot, source = self._urdf()
        for left in getattr(robot, "left_out", ()):
            self._warn("missing-package", f"{left}; what would come from it is left out".replace(".;", ";"), source)
        self.findings += check_urdf(robot, str(source), self.packages)
        description = None if self._wrong() else self._described(robot, source)
        packages = (self.moveit,) if self.chosen is not None else ()
        return Inspected(tuple(self.findings), None if self._wrong() else description, packages, self.chosen)

    def _choose(self, folder: Path) -> None:
        """Take the configuration of a package that the description asks for, or its first, and say so."""
        if not folder.is_dir():
            raise DocumentError("there is no such folder", str(folder))
        folder = self._package_in(folder)
        self.packages = Packages(self.packages.given, (folder / MANIFEST,))
        found = Configurations(folder, self.packages)
        asked = self.config.arguments
        given = self.config.urdf or self.config.xacro
        urdf = None if given is None else self._path(given)
        if self.config.srdf is not None:
            srdf = self._path(self.config.srdf)
            choice = Alternative(srdf.name.split(".")[0], srdf)
        else:
            every = found.alternatives()
            if not every:
                raise DocumentError("it holds no SRDF and no URDF, neither does a package that it names", str(folder))
            told = [each for each in every if each.arguments and each.arguments.items() <= asked.items()]
            choice = (told or every)[0]
            others = [each.name for each in every if each is not choice]
            if others and not told:
                how = "arguments" if choice.arguments else "srdf" if choice.srdf else "urdf"
                self._warn_of_others(choice.name, how, others, folder)
        choice = replace(choice, arguments={**choice.arguments, **asked}, urdf=urdf or choice.urdf)
        self.chosen = found.fitted(choice)
        if self.chosen.fit < 1:
            part = f"only {100 * self.chosen.fit:.0f} % of the SRDF's names are in {self.chosen.urdf}"
            self._warn("odd-urdf", part, folder)
        self.moveit = read_package(folder, self.chosen)
        self.findings += self.moveit.findings

    def _package_in(self, workspace: Path) -> Path:
        """Return a folder's configuration package: that of the SRDF which the description names, or its first."""
        found = configured_packages(workspace)
        srdf = None if self.config.srdf is None else self._path(self.config.srdf).resolve()
        fit = [each for each in found if srdf is None or srdf.is_relative_to(each.resolve())] or [workspace]
        if others := [str(each.relative_to(workspace)) for each in fit[1:]]:
            self._warn_of_others(str(fit[0].relative_to(workspace)), "moveit", others, workspace)
        return fit[0]

    def _warn_of_others(self, taken: str, key: str, others: list[str], place: Path) -> None:
        more = f"of several configurations {taken} is taken; others, for `{key}:`, are {listing(others)}"
        self._warn("several-configurations", more, place)

    def _described(self, robot: ET.Element, source: Path) -> RobotDescription | None:
        tree = Tree(robot)
        known, told = with_known_names(self._srdf(), tree)
        self.findings += told
        srdf, guess = with_groups(with_config(known, self.config), tree)
        self.findings += filter(None, [guess])
        added, told = with_states(srdf, self.config, tree)
        self.findings += told
        if self._wrong():
            return None
        initial = self.moveit.initial_positions
        self.findings += _check_names(self.config, tree, added, self.moveit.limits, initial)
        odd = dict(_odd_limits(self.moveit.limits, tree))
        self.findings += odd.values()
        limits = {joint: limit for joint, limit in self.moveit.limits.items() if joint not in odd}
        if self._wrong():
            return None
        name = self.config.name or robot.get("name") or "robot"
        urdf = normal(robot, name, source.parent, self.packages, limits)
        made = build(urdf, added, self.config, limits, initial)
        for completed in (with_postures, with_efforts):
            made, told = completed(made)
            self.findings += told
        return replace(made, preferences=preferences_of(self.moveit, made.groups, PLANNERS))

    def _urdf(self) -> tuple[ET.Element, Path]:
        config = self.config
        if self.chosen is not None and self.chosen.urdf is not None:
            return self.chosen.robot, self.chosen.urdf
        path = self._path(config.urdf or config.xacro or "")
        if config.urdf is not None and path.suffix != ".xacro":
            if config.arguments:
                self._warn("unused-arguments", "arguments are for xacro files; this URDF takes none", path)
        else:
            self._check_arguments(path)
        return read_robot(path, config.arguments, self.packages), path

    def _srdf(self) -> Srdf:
        if self.chosen is not None and self.chosen.semantic is not None:
            return read_srdf(self.chosen.semantic, str(self.chosen.srdf))
        if self.config.srdf is not None:
            path = self._path(self.config.srdf)
            return read_srdf(read_robot(path, self.config.arguments, self.packages), str(path))
        return Srdf()

    def _check_arguments(self, path: Path) -> None:
        known = tuple(declared(path, self.packages).arguments)
        for name in self.config.arguments:
            if name not in known:
                self._warn(
                    "unknown-argument",
                    f"the file declares no argument {name!r}{nearest(name, known)} (it declares: "
                    f"{', '.join(known) or 'none'}); only a file that it includes can use it",
                    path,
                )

    def _path(self, word: str) -> Path:
        return self.packages.resolve(word, self.folder) if "://" in word else (self.folder / Path(word).expanduser())

    def _wrong(self) -> bool:
        return bool(errors(self.findings))

    def _warn(self, code: str, message: str, path: Path | None) -> None:
        self.findings.append(robot_issue("warning", code, message, "" if path is None else str(path)))


def _check_names(
    config: RobotConfig, tree: Tree, srdf: Srdf, limits: Mapping[str, JointLimits], initial: Mapping[str, float]
) -> Iterator[Issue]:
    """Yield what a configuration and a MoveIt package name that isn't there."""
    groups, links, joints = list(srdf.groups), list(tree.links), list(tree.joints)
    named = [
        *(("group", group, groups, "grasp_frames") for group in config.grasp_frames),
        *(("link", frame.link, links, f"grasp_frames/{group}") for group, frame in config.grasp_frames.items()),
        *(("group", group, groups, "fingers") for group in config.fingers),
        *(
            ("link", link, links, f"fingers/{group}/{finger}")
            for group, fingers in config.fingers.items()
            for finger, mine in fingers.items()
            for link in mine
        ),
        *(("group", group, groups, "drives") for group in config.drives),
        *(("joint", name, groups + joints, "accelerations") for name in config.accelerations),
        *(("joint", name, joints, "joint_limits.yaml") for name in limits),
        *(("joint", name, joints, "initial_positions.yaml") for name in initial),
    ]
    for kind, name, allowed, where in named:
        if name not in allowed:
            message = f"{where}: there is no {kind} {name!r}{nearest(name, allowed)}"
            yield robot_issue("warning" if where.endswith(".yaml") else "error", f"unknown-{kind}", message)


def _odd_limits(limits: Mapping[str, JointLimits], tree: Tree) -> Iterator[tuple[str, Issue]]:
    """Yield the joints that limits of a MoveIt package would keep from moving."""
    for name, limit in limits.items():
        joint = tree.joints.get(name)
        if joint is None or joint.type not in ("revolute", "prismatic"):
            continue
        lower = joint.lower if limit.lower is None else limit.lower
        upper = joint.upper if limit.upper is None else limit.upper
        if not lower < upper or (limit.velocity is not None and limit.velocity <= 0):
            message = (
                f"joint_limits.yaml: joint {name!r} can't move: positions {lower:g} ... {upper:g}, velocity "
                f"{joint.velocity if limit.velocity is None else limit.velocity:g}; the URDF's limits are taken"
            )
            yield name, robot_issue("warning", "missing-limit", message)
