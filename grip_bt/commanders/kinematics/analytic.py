"""Inverse kinematics of six-joint arms in closed form, by EAIK (Ostermeier et al. 2024).

It takes arms whose axes meet or run parallel in ways that have a known decomposition, such as a spherical wrist or
the three parallel axes of a UR, and gives all solutions within microseconds. Targets with a freedom have no finite
set of solutions: those are left to damped least squares.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array
from grip_bt.base.errors import UnfitSolverError

from . import damped_least_squares
from .damped_least_squares import Target
from .model import Chain
from .trac_ik import axis_of, kept_with_chain, moved_by

_TURN = 2 * np.pi


def solutions(
    chain: Chain, target: Target, rng: np.random.Generator, seeds: tuple[Array, ...] = (), restarts: int = 20
) -> Iterator[Array]:
    """Yield all configurations within the limits that reach `target`, the nearest to the first seed first.

    Raises:
        UnfitSolverError: the arm hasn't six turning joints with a known decomposition.
    """
    arm = _arm(chain)
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
        from eaik.IK_HP import HPRobot

        axes, origins, tip = _at_zero(chain)
        offsets = np.diff(np.vstack([np.zeros(3), origins, tip.translation]), axis=0)
        self._limits, self._unturned = chain.limits, tip.rotation.T
        self._solver: Any = HPRobot(axes, offsets)
        if not self._solver.hasKnownDecomposition():
            raise UnfitSolverError(f"{_NAME}: the axes of {_joints(chain)} have no known decomposition; {_INSTEAD}")

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


@kept_with_chain
def _arm(chain: Chain) -> _Arm:
    joints = moved_by(chain)
    kinds = [axis_of(chain.model.joints[joint])[0] for joint in joints]
    if len(kinds) != 6 or not all(kinds) or len(joints) != len(chain.joints):
        raise UnfitSolverError(f"{_NAME} needs six turning joints in a row; {_joints(chain)} aren't; {_INSTEAD}")
    return _Arm(chain)


def _at_zero(chain: Chain) -> tuple[Array, Array, pin.SE3]:
    """Return the axes, shape (6, 3), a point on each, shape (6, 3), and the grasp frame, all in world."""
    model, data = chain.model, chain.model.createData()
    pin.framesForwardKinematics(model, data, np.zeros(model.nq))
    placements = [data.oMi[joint] for joint in moved_by(chain)]
    axes = [place.rotation @ axis_of(model.joints[j])[1] for j, place in zip(moved_by(chain), placements, strict=True)]
    return np.array(axes), np.array([place.translation for place in placements]), data.oMf[chain.frame].copy()


_NAME = "the kinematics 'analytic'"
_INSTEAD = "take 'damped_least_squares' or 'trac_ik'"


def _joints(chain: Chain) -> str:
    return f"the {len(chain.joints)} joints {', '.join(chain.joints)}"
