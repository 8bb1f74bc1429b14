"""Inverse kinematics by damped least squares, its starts taken from an atlas of the arm's configurations.

A random start ends in a local minimum or at a limit about every third time; a start whose grasp frame already lies
close to the target seldom does, and needs half the steps. Known as IK seed tables (e.g. Vahrenkamp et al. 2013,
"reachability inversion"). The sample is drawn with a fixed seed: the same question has the same answer.

Method: Levenberg-Marquardt steps with damping that grows with the error (Chan and Lawrence 1988, Sugihara 2011),
positions clamped to the limits. It takes every target, full or partial, and repeats exactly.
"""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array

from .model import Chain
from .target import Target

SIZE = 20_000
"""Configurations filed; more than that shortens searches by little."""
_METRES_PER_TURN = 0.3
"""How many metres count like a wrong rotation matrix of norm one, about a turn by 40 degrees."""
_KEPT = 8


class Atlas:
    """A sample of an arm's configurations that can be asked for those near a target."""

    def __init__(self, chain: Chain):
        from scipy.spatial import cKDTree  # half a second, which only who searches needs

        rng = np.random.default_rng(0)
        self._configurations = rng.uniform(chain.limits.lower, chain.limits.upper, (SIZE, len(chain.joints)))
        positions, rotations = np.empty((SIZE, 3)), np.empty((SIZE, 9))
        for row, q in enumerate(self._configurations):
            pin.framesForwardKinematics(chain.model, chain.data, q)
            placement = chain.data.oMf[chain.frame]
            positions[row], rotations[row] = placement.translation, placement.rotation.T.ravel()
        self._positions = positions
        self._trees = {"orientation": cKDTree(positions)}
        scaled = rotations * _METRES_PER_TURN
        self._trees["none"] = cKDTree(np.hstack([positions, scaled]))
        for k, axis in enumerate("xyz"):
            self._trees[axis] = cKDTree(np.hstack([positions, scaled[:, 3 * k : 3 * k + 3]]))

    def near(self, target: Target, count: int) -> Array:
        """Return the configurations, shape (count, n), whose grasp frame is closest to the target, closest first."""
        position, rotation = target.pose.translation, target.pose.rotation.T * _METRES_PER_TURN
        if target.free == "orientation":
            key = position
        elif target.free == "none":
            key = np.concatenate([position, rotation.ravel()])
        else:
            key = np.concatenate([position, rotation["xyz".index(target.free)]])
        _, rows = self._trees[target.free].query(key, k=count)
        return self._configurations[np.atleast_1d(rows)]


_atlases: OrderedDict[bytes, Atlas] = OrderedDict()
_lock = threading.Lock()


def atlas_of(chain: Chain) -> Atlas:
    """Return the atlas of an arm, made on first use (about 0.3 s) and kept for the last few arms.

    What a hand's fingers do doesn't matter to it: arms with the same joints, limits and grasp frame share one.
    """
    key = _geometry(chain)
    with _lock:
        if key in _atlases:
            _atlases.move_to_end(key)
        else:
            _atlases[key] = Atlas(chain)
            while len(_atlases) > _KEPT:
                _atlases.popitem(last=False)
        return _atlases[key]


def _geometry(chain: Chain) -> bytes:
    model, frame = chain.model, chain.model.frames[chain.frame]
    placements = [placement.homogeneous for placement in (*model.jointPlacements, frame.placement)]
    kinds = " ".join(joint.shortname() for joint in model.joints)
    numbers = np.concatenate([np.ravel(placements), chain.limits.lower, chain.limits.upper])
    return f"{kinds} {frame.parentJoint} ".encode() + np.round(numbers, 9).tobytes()


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
