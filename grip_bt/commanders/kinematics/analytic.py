"""Inverse kinematics of six-joint arms in closed form, by EAIK (Ostermeier et al. 2024): all solutions in microseconds.

It takes arms whose axes have a known decomposition, such as a spherical wrist or the three parallel axes of a UR.
Targets with a freedom have no finite set of solutions: those are left to damped least squares.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array
from grip_bt.base.errors import UnfitSolverError

from . import damped_least_squares
from .damped_least_squares import Target
from .model import Chain
from .trac_ik import at_zero

_TURN = 2 * np.pi


def solutions(
    chain: Chain, target: Target, rng: np.random.Generator, seeds: tuple[Array, ...] = (), restarts: int = 20
) -> Iterator[Array]:
    """Yield all configurations within the limits that reach `target`, the nearest to the first seed first.

    Raises:
        UnfitSolverError: the arm hasn't six turning joints with a known decomposition.
    """
    arm = _arm_of(chain)
    if target.free != "none":
        yield from damped_least_squares.solutions(chain, target, rng, seeds, restarts)
        return
    found = [q for q in arm.all(target.pose) if target.distance(chain, q) < damped_least_squares.TOLERANCE]
    if not restarts:
        found = [min(found, key=lambda q: float(np.linalg.norm(q - seed))) for seed in seeds if found]
    elif seeds:
        found.sort(key=lambda q: float(np.linalg.norm(q - seeds[0])))
    yield from found


class _Arm:
    """An arm as axes and offsets at its zero configuration, as EAIK wants it."""

    def __init__(self, chain: Chain):
        joints, words = at_zero(chain), f"the {len(chain.joints)} joints {', '.join(chain.joints)}"
        if len(joints) != 6 or not all(turns for turns, _, _ in joints) or len(joints) != len(chain.joints):
            raise UnfitSolverError(f"{_NAME} needs six turning joints in a row; {words} aren't; {_INSTEAD}")
        from eaik.IK_HP import HPRobot

        tip = chain.grasp_pose(np.zeros(chain.model.nq))
        places = [np.zeros(3), *(frame.translation for _, _, frame in joints), tip.translation]
        self._limits, self._unturned = chain.limits, tip.rotation.T
        self._solver: Any = HPRobot(np.array([axis for _, axis, _ in joints]), np.diff(np.array(places), axis=0))
        if not self._solver.hasKnownDecomposition():
            raise UnfitSolverError(f"{_NAME}: the axes of {words} have no known decomposition; {_INSTEAD}")

    def all(self, pose: pin.SE3) -> Iterator[Array]:
        """Yield every configuration within the limits, whole turns added where they allow it."""
        wanted = pose.homogeneous
        wanted[:3, :3] = pose.rotation @ self._unturned
        for q in np.atleast_2d(np.array(self._solver.IK(wanted).Q, dtype=float).reshape(-1, len(self._limits.lower))):
            turns = [
                [p + k * _TURN for k in (0, -1, 1) if low <= p + k * _TURN <= high]
                for p, low, high in zip(q, self._limits.lower, self._limits.upper, strict=True)
            ]
            yield from (np.array(turned) for turned in product(*turns))


_NAME = "the kinematics 'analytic'"
_INSTEAD = "take 'damped_least_squares' or 'trac_ik'"
_arm_of = lru_cache(maxsize=8)(_Arm)
