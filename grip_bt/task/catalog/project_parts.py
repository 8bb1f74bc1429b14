"""What a project's arms, hands and nodes have, by name: words, so that tasks are checked with no robot at hand."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Literal

from grip_bt.base.errors import listing, nearest

Names = Literal["arm", "arms", "hand", "state", "taught", "posture", "finger", "tip", "link", "interface"]
"""What a parameter may name: an arm, several, a hand, a named state of the arm, a state or pose that was taught to it,
a posture of the hand, its fingers, its fingers or links, a link, a type of ROS. Of a mapping, `finger` and `tip` mean
the keys, `interface` the values."""
UNFIT_PROJECT, MISSING_PACKAGE, NO_CONTROLLER = "unfit-project", "missing-package", "no-controller"
"""Codes of problems."""
_MOST = 12
"""How many types of a package are listed."""


@dataclass(frozen=True, slots=True)
class Problem:
    """Why something that the project declares won't work."""

    code: str
    message: str
    fix: str = ""


@dataclass(frozen=True, slots=True)
class PartNames:
    """An arm or a hand.

    Attributes:
        known: what its parameters may name -> the names; a kind that it lacks isn't known, and nothing is said of it.
        problems: what is wrong with what the project says of it.
    """

    known: Mapping[str, Collection[str]] = field(default_factory=dict)
    problems: tuple[Problem, ...] = ()


@dataclass(frozen=True, slots=True)
class ProjectParts:
    """A project's parts.

    Attributes:
        arms: by name; None where the project declares no robot yet.
        nodes: id of a node -> what is wrong with what it needs, such as a ROS package that isn't installed.
        packages: ROS packages that are here, as a mapping also what looks up the types of each (`msg/Pose`); None where
            there is no ROS, and tasks are only drawn.
    """

    arms: Mapping[str, PartNames] | None = None
    hands: Mapping[str, PartNames] | None = None
    nodes: Mapping[str, tuple[Problem, ...]] = field(default_factory=dict)
    packages: Collection[str] | None = None


def missing_package(name: str, packages: Collection[str], where: str = "") -> Problem:
    """Return that a ROS package isn't here, which is needed by what stands at `where`."""
    lead = f"{where}: " if where else ""
    message = f"{lead}the ROS package {name!r} isn't installed{nearest(name, sorted(packages))}"
    return Problem(
        MISSING_PACKAGE, message, "install it, source its workspace, or build it: `grip interfaces build DIR`"
    )


def missing_type(type_: str, packages: Collection[str], where: str = "", message: bool = False) -> Problem | None:
    """Return that a ROS type isn't here, or None where it is, or nobody knows.

    Args:
        packages: those that are here, as `ProjectParts` has them.
        message: whether a message is needed, as topics carry it, and no service or action.
    """
    package, _, rest = type_.partition("/")
    if package not in packages:
        return missing_package(package, packages, where)
    known = packages[package]() if isinstance(packages, Mapping) else ()
    name = rest if "/" in rest else f"msg/{rest}"
    lead = f"{where}: " if where else ""
    if message and "/" in name and not name.startswith("msg/"):
        said = f"{lead}{type_!r} isn't a message, and a topic carries messages"
        return Problem(MISSING_PACKAGE, said, "name its message, or wrap it as a component: `grip component add`")
    if not known or name in known:
        return None
    same_kind = sorted(f"{package}/{n}" for n in known if n.partition("/")[0] == name.partition("/")[0])
    hint = nearest(name.rpartition("/")[2], [n.rpartition("/")[2] for n in same_kind])
    there_are = f" (available: {listing(same_kind[:_MOST])}{', ...' if len(same_kind) > _MOST else ''})"
    said = f"{lead}the ROS package {package!r} has no {name!r}{hint or there_are}"
    return Problem(MISSING_PACKAGE, said, "name one that it has, or install the release that has it")
