"""Inverse kinematics by TRAC-IK (Beeson and Ames 2015), from the `pytracik` wheel.

Two of its threads race, a Newton descent and sequential quadratic programming, and the first one that arrives wins:
it is robust, and doesn't repeat. What it returns is checked against our own forward kinematics. The wheel takes whole
poses only, so partial targets are solved by damped least squares.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array

from ..model import Chain
from . import damped_least_squares
from .serial import BASE, TIP, kept_with_chain, moved_by, urdf_of
from .target import Target

_TIME = 0.005
"""Longest time of one attempt [s]; TRAC-IK's own default."""
_NEAR = 0.3
"""A seed whose grasp frame is this near the target [m + rad] is gone down from before the race."""
_PRECISION = 1e-5
"""Largest error in each direction [m, rad]: the norm of six of them stays below our tolerance."""


def solutions(
    chain: Chain, target: Target, rng: np.random.Generator, seeds: tuple[Array, ...] = (), restarts: int = 20
) -> Iterator[Array]:
    """Yield configurations that reach `target`; those from `seeds` come first."""
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


@kept_with_chain
def _engine(chain: Chain) -> Any:
    wheel = _wheel()
    return wheel.TRAC_IK(BASE, TIP, urdf_of(chain), _TIME, _PRECISION, wheel.SolveType.Speed)


def _wheel() -> Any:
    import pytracik

    return pytracik
