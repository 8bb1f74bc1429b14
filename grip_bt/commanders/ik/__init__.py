"""Inverse kinematics: solvers by the name that a project file gives in `kinematics:`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any

from grip_bt.errors import UnknownNameError

from . import damped_least_squares

Solutions = Callable[..., Iterator[Any]]
"""`(chain, target, rng, seeds, restarts) -> configurations`; see `damped_least_squares.solutions`."""

SOLVERS: Mapping[str, Solutions] = MappingProxyType({"damped_least_squares": damped_least_squares.solutions})


def solver(name: str) -> Solutions:
    """Return a solver.

    Raises:
        UnknownNameError: there is no such solver.
    """
    if name not in SOLVERS:
        raise UnknownNameError("kinematics solver", name, SOLVERS)
    return SOLVERS[name]
