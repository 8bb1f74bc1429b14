"""Inverse kinematics as tests ask for it: the first solution, or the nearest one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from grip_bt.base.arrays import Configuration
from grip_bt.commanders.kinematics.damped_least_squares import Target
from grip_bt.commanders.kinematics.ik import solver
from grip_bt.commanders.kinematics.model import Chain


def solve(
    chain: Chain,
    target: Target,
    rng: np.random.Generator,
    seeds: tuple[Configuration, ...] = (),
    restarts: int = 20,
    accept: Callable[[Configuration], bool] = lambda q: True,
    kinematics: str = "damped_least_squares",
) -> Configuration | None:
    """Return the first solution that `accept` takes, or None."""
    return next((q for q in solver(kinematics)(chain, target, rng, seeds, restarts) if accept(q)), None)


def nearest(
    chain: Chain, target: Target, rng: np.random.Generator, seed: Configuration, kinematics: str
) -> Configuration | None:
    """Return the solution whose joints are nearest to `seed` among all that are found, or None."""
    found = solver(kinematics)(chain, target, rng, (seed,), 20)
    return min(found, key=lambda q: float(np.linalg.norm(q - seed)), default=None)
