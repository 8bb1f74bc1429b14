"""Inverse kinematics by damped least squares on the SE(3) logarithm of the error, with restarts.

Method: Levenberg-Marquardt steps with damping that grows with the error (Chan and Lawrence 1988, Sugihara 2011),
positions clamped to the limits. It takes every target, full or partial, and repeats exactly.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from grip_bt.base.arrays import Array

from ..model import Chain
from .atlas import atlas_of
from .target import Target

TOLERANCE = 1e-4
"""Largest norm of the error: metres and radians together."""
_DAMPING = 1e-4
_MAX_STEP = 0.5
_NEAR = 1.0
"""A seed whose grasp frame is further from the target [m + rad] is no better a start than one from the atlas."""


def solve_from(chain: Chain, target: Target, start: Array, iterations: int = 30) -> Array | None:
    """Return the configuration, shape (n,), that the descent from `start` reaches, or None when it doesn't converge."""
    lower, upper = chain.limits.lower, chain.limits.upper
    q = np.clip(start, lower, upper)
    for _ in range(iterations):
        error, jacobian = target.error(chain, q)
        squared = float(error @ error)
        if squared < TOLERANCE**2:
            return q
        damping = _DAMPING * max(1e-2, squared) * np.eye(len(error))
        step = -jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + damping, error)
        largest = float(np.abs(step).max())
        q = np.clip(q + (step * (_MAX_STEP / largest) if largest > _MAX_STEP else step), lower, upper)
    return None


def solutions(
    chain: Chain, target: Target, rng: np.random.Generator, seeds: tuple[Array, ...] = (), restarts: int = 20
) -> Iterator[Array]:
    """Yield configurations that reach `target`; those near `seeds` come first.

    Args:
        rng: where random restarts come from.
        seeds: configurations to start from, where they put the grasp frame near the target.
        restarts: how many more starts follow: half of them from the arm's atlas, then random ones.
    """
    for seed in seeds:
        if target.distance(chain, np.clip(seed, chain.limits.lower, chain.limits.upper)) < _NEAR:
            yield from _reached(chain, target, seed)
    near = (restarts + 1) // 2
    if near:
        for start in atlas_of(chain).near(target, near):
            yield from _reached(chain, target, start)
    for _ in range(restarts - near):
        yield from _reached(chain, target, rng.uniform(chain.limits.lower, chain.limits.upper))


def _reached(chain: Chain, target: Target, start: Array) -> Iterator[Array]:
    q = solve_from(chain, target, start)
    if q is not None:
        yield q
