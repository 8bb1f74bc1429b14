"""Inverse kinematics: solvers by the name that a project file gives in `kinematics:`, and TRAC-IK as one of them."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array
from grip_bt.base.errors import UnknownNameError

from . import damped_least_squares
from .damped_least_squares import Target
from .model import Chain

BASE, TIP = "base", "tip"


def moved_by(chain: Chain) -> list[int]:
    """Return the ids of the joints that move the grasp frame, from the base on."""
    return list(chain.model.supports[chain.model.frames[chain.frame].parentJoint])[1:]


def urdf_of(chain: Chain) -> str:
    """Return a URDF of nothing but the chain's kinematics, from link `base` to link `tip`, the grasp frame."""
    model, robot = chain.model, ET.Element("robot", name="chain")
    ET.SubElement(robot, "link", name=BASE)
    parent = BASE
    for joint in moved_by(chain):
        column, name = model.joints[joint].idx_q, str(model.names[joint])
        linear, angular = np.split(model.joints[joint].createData().S.ravel(), 2)
        kind = "revolute" if angular.any() else "prismatic"
        element = _joint(robot, name, kind, parent, name, model.jointPlacements[joint])
        ET.SubElement(element, "axis", xyz=_numbers(linear + angular))
        lower, upper = (repr(float(limit[column])) for limit in (chain.limits.lower, chain.limits.upper))
        ET.SubElement(element, "limit", lower=lower, upper=upper, velocity="1", effort="1")
        parent = name
    _joint(robot, TIP, "fixed", parent, TIP, model.frames[chain.frame].placement)
    return ET.tostring(robot, encoding="unicode")


def _joint(robot: ET.Element, name: str, kind: str, parent: str, child: str, place: pin.SE3) -> ET.Element:
    ET.SubElement(robot, "link", name=child)
    joint = ET.SubElement(robot, "joint", name=f"{name}_joint", type=kind)
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    angles = pin.rpy.matrixToRpy(place.rotation)
    ET.SubElement(joint, "origin", xyz=_numbers(place.translation), rpy=_numbers(angles))
    return joint


def _numbers(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


_TIME = 0.005
"""Longest time of one attempt [s]; TRAC-IK's own default."""
_NEAR = 0.3
"""A seed whose grasp frame is this near the target [m + rad] is descended from before the race."""
_PRECISION = 1e-5
"""Largest error in each direction [m, rad]: the norm of six of them stays below our tolerance."""


def _by_trac_ik(
    chain: Chain, target: Target, rng: np.random.Generator, seeds: tuple[Array, ...] = (), restarts: int = 20
) -> Iterator[Array]:
    """Yield configurations that reach `target`; those from `seeds` come first.

    TRAC-IK is robust, and doesn't repeat: two threads race. What it returns is checked against our own forward
    kinematics. The wheel takes whole poses only, so partial targets are solved by damped least squares.
    """
    if target.free != "none":
        yield from damped_least_squares.solutions(chain, target, rng, seeds, restarts)
        return
    for seed in seeds:
        # The race may end anywhere; what lies next to a seed is found by going down from it.
        near = target.distance(chain, np.clip(seed, chain.limits.lower, chain.limits.upper)) < _NEAR
        q = damped_least_squares.solve_from(chain, target, seed) if near else None
        if q is not None:
            yield q
    engine, lower, upper = _engine(chain), chain.limits.lower, chain.limits.upper
    columns = [chain.model.joints[joint].idx_q for joint in moved_by(chain)]
    place = pin.SE3ToXYZQUAT(target.pose)
    for attempt in range(len(seeds) + restarts):
        start = np.clip(seeds[attempt], lower, upper) if attempt < len(seeds) else rng.uniform(lower, upper)
        code, *positions = _wheel().ik(engine, start[columns], *place)
        q = start.copy()
        q[columns] = positions
        # The wheel's word isn't enough: what counts is our model of the robot.
        if code >= 0 and chain.within_limits(q) and target.distance(chain, q) < damped_least_squares.TOLERANCE:
            yield q


@lru_cache(maxsize=8)
def _engine(chain: Chain) -> Any:
    wheel = _wheel()
    return wheel.TRAC_IK(BASE, TIP, urdf_of(chain), _TIME, _PRECISION, wheel.SolveType.Speed)


def _wheel() -> Any:
    import pytracik

    return pytracik


Solutions = Callable[..., Iterator[Array]]
"""`(chain, target, rng, seeds, restarts) -> configurations`; see `damped_least_squares.solutions`."""

SOLVERS: Mapping[str, Solutions] = MappingProxyType(
    {"damped_least_squares": damped_least_squares.solutions, "trac_ik": _by_trac_ik}
)
APART = 0.05
"""Two solutions closer than this in every joint are one [rad]."""


def solver(name: str) -> Solutions:
    """Return a solver; what it yields is distinct. Raises UnknownNameError: there is no such solver."""
    if name not in SOLVERS:
        raise UnknownNameError("kinematics solver", name, SOLVERS)
    find = SOLVERS[name]
    return lambda *arguments, **named: distinct(find(*arguments, **named))


def distinct(configurations: Iterator[Array]) -> Iterator[Array]:
    """Leave out configurations, shape (n,), that differ from an earlier one by less than 0.05 rad in every joint."""
    seen: list[Array] = []
    for q in configurations:
        if all(np.abs(q - other).max() >= APART for other in seen):
            seen.append(q)
            yield q
