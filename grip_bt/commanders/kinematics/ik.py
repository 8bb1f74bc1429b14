"""Inverse kinematics: solvers by the name that a project file gives in `kinematics:`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.errors import UnknownNameError

from . import damped_least_squares, trac_ik

Solutions = Callable[..., Iterator[Array]]
"""`(chain, target, rng, seeds, restarts) -> configurations`; see `damped_least_squares.solutions`."""

SOLVERS: Mapping[str, Solutions] = MappingProxyType(
    {"damped_least_squares": damped_least_squares.solutions, "trac_ik": trac_ik.solutions}
)
APART = 0.05
"""Two solutions closer than this in every joint are one [rad]."""


def solver(name: str) -> Solutions:
    """Return a solver; what it yields is distinct.

    Raises:
        UnknownNameError: there is no such solver.
    """
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
