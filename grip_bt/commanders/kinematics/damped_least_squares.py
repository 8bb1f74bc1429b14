"""Inverse kinematics by damped least squares, its starts from an atlas of the arm's configurations; what is asked for.

Known as IK seed tables (e.g. Vahrenkamp et al. 2013, "reachability inversion"): a start whose grasp frame lies close to
the target seldom ends in a local minimum, and needs half the steps. The sample has a fixed seed.

Method: Levenberg-Marquardt steps with damping that grows with the error (Chan and Lawrence 1988, Sugihara 2011),
positions clamped to the limits. It takes every target, full or partial, and repeats exactly.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain as chained

import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array
from grip_bt.base.errors import UnknownNameError
from grip_bt.base.ports.motion import FREEDOMS, Free

from .model import Chain


@dataclass(frozen=True, slots=True)
class Target:
    """A wanted grasp frame.

    Attributes:
        pose: the grasp frame in world.
        free: what of it doesn't matter. With `z`, say, the frame's z axis and origin must be as in `pose`, and it
            may be turned about z as it likes: right for a round object seen from above.

    Raises:
        UnknownNameError: `free` is none of the allowed words.
    """

    pose: pin.SE3
    free: Free = "none"

    def __post_init__(self) -> None:
        if self.free not in FREEDOMS:
            raise UnknownNameError("freedom of a pose", self.free, FREEDOMS)

    def error(self, chain: Chain, q: Array) -> tuple[Array, Array]:
        """Return what is missing to the target, and how that changes with the joints.

        Returns:
            The error, shape (m,), in metres and radians, in the grasp frame, and its derivative by the
            configuration, shape (m, n); m is 6, 5 with a free axis, 3 with a free orientation.
        """
        model, data, frame = chain.model, chain.data, chain.frame
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacement(model, data, frame)
        missing = data.oMf[frame].actInv(self.pose)
        jacobian = pin.getFrameJacobian(model, data, frame, pin.LOCAL)
        if self.free == "none":
            return pin.log6(missing).vector, -(pin.Jlog6(missing.inverse()) @ jacobian)
        return _partial(self.free, missing, jacobian)

    def distance(self, chain: Chain, q: Array) -> float:
        """Return the norm of the error at a configuration of shape (n,): metres and radians together."""
        return float(np.linalg.norm(self.error(chain, q)[0]))


def _partial(free: Free, missing: pin.SE3, jacobian: Array) -> tuple[Array, Array]:
    """Return the error in position and, unless the orientation is free, in the direction of the axis that is kept.

    Axis a of the grasp frame must point along b = R a (both in the grasp frame). The error is the turn from a to b:
    along a x b, which has no part about a, so that row is left out. Its derivative is that of small turns.
    """
    position = missing.translation
    linear = pin.skew(position) @ jacobian[3:] - jacobian[:3]
    if free == "orientation":
        return position, linear
    k = "xyz".index(free)
    turn = np.cross(np.eye(3)[k], missing.rotation[:, k])
    sine, cosine = float(np.linalg.norm(turn)), float(missing.rotation[k, k])
    if sine < 1e-9:
        # Parallel is done; opposite can be left by a turn about any axis across.
        turn, sine = np.eye(3)[(k + 1) % 3], 1.0
        angle = 0.0 if cosine > 0 else np.pi
    else:
        angle = float(np.arctan2(sine, cosine))
    rows = [i for i in range(3) if i != k]
    error = np.concatenate([position, turn[rows] * (angle / sine)])
    return error, np.vstack([linear, -jacobian[3:][rows]])


SIZE = 20_000
"""Configurations filed; more than that shortens searches by little."""
_METRES_PER_TURN = 0.3
"""How many metres count like a wrong rotation matrix of norm one, about a turn by 40 degrees."""
_KEPT = 8


class Atlas:
    """A sample of an arm's configurations that can be asked for those near a target."""

    def __init__(self, chain: Chain):
        rng = np.random.default_rng(0)
        self._configurations = rng.uniform(chain.limits.lower, chain.limits.upper, (SIZE, len(chain.joints)))
        places = [chain.grasp_pose(q).homogeneous for q in self._configurations]
        self._columns = np.stack(places, dtype=np.float32)[:, :3].transpose(2, 1, 0).copy()

    def near(self, target: Target, count: int) -> Array:
        """Return the configurations, shape (count, n), whose grasp frame is closest to the target, closest first."""
        apart = np.zeros(SIZE, dtype=np.float32)
        for axis in {"none": "xyzp", "orientation": "p"}.get(target.free, f"{target.free}p"):
            k, weight = "xyzp".index(axis), 1.0 if axis == "p" else _METRES_PER_TURN
            for numbers, wanted in zip(self._columns[k], target.pose.homogeneous[:3, k], strict=True):
                apart += np.square((numbers - np.float32(wanted)) * np.float32(weight))
        rows = np.argpartition(apart, count)[:count]
        return self._configurations[rows[np.argsort(apart[rows])]]


_atlases: dict[bytes, Atlas] = {}
_lock = threading.Lock()


def atlas_of(chain: Chain) -> Atlas:
    """Return the atlas of an arm, made on first use (about 0.3 s) and kept for the last few arms.

    What a hand's fingers do doesn't matter to it: arms with the same joints, limits and grasp frame share one.
    """
    model, frame = chain.model, chain.model.frames[chain.frame]
    placements = [placement.homogeneous for placement in (*model.jointPlacements, frame.placement)]
    numbers = np.concatenate([np.ravel(placements), chain.limits.lower, chain.limits.upper])
    kinds = " ".join(joint.shortname() for joint in model.joints)
    key = f"{kinds} {frame.parentJoint} ".encode() + np.round(numbers, 9).tobytes()
    with _lock:
        if key not in _atlases and len(_atlases) >= _KEPT:
            _atlases.pop(next(iter(_atlases)))
        return _atlases.setdefault(key, _atlases.get(key) or Atlas(chain))


TOLERANCE = 1e-4
"""Largest norm of the error: metres and radians together."""
_DAMPING = 1e-4
_MAX_STEP, _STEPS = 0.5, 30
_ONES = {m: np.eye(m) for m in (3, 5, 6)}
_NEAR = 1.0
"""A seed whose grasp frame is further from the target [m + rad] is no better a start than one from the atlas."""


def solve_from(chain: Chain, target: Target, start: Array) -> Array | None:
    """Return the configuration, shape (n,), that the descent from `start` reaches, or None when it doesn't converge."""
    lower, upper = chain.limits.lower, chain.limits.upper
    q = np.clip(start, lower, upper)
    for _ in range(_STEPS):
        error, jacobian = target.error(chain, q)
        squared = float(error @ error)
        if squared < TOLERANCE**2:
            return q
        damping = _DAMPING * max(1e-2, squared) * _ONES[len(error)]
        step = -jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + damping, error)
        largest = float(np.abs(step).max())
        q = q + (step * (_MAX_STEP / largest) if largest > _MAX_STEP else step)
        q = np.minimum(np.maximum(q, lower), upper)  # a third of the time that `clip` takes
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
    lower, upper, half = chain.limits.lower, chain.limits.upper, (restarts + 1) // 2
    starts = chained(
        (seed for seed in seeds if target.distance(chain, np.clip(seed, lower, upper)) < _NEAR),
        (start for _ in range(half > 0) for start in atlas_of(chain).near(target, half)),
        (rng.uniform(lower, upper) for _ in range(restarts - half)),
    )
    yield from (q for q in (solve_from(chain, target, start) for start in starts) if q is not None)
