"""Piecewise linear paths in joint space: arrays of shape (k, n) whose rows are configurations."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin

from grip_bt.base.arrays import Array, Path
from grip_bt.base.values import PathConstraint

from ..kinematics.model import Chain

EdgeCheck = Callable[[Array, Array], bool]
"""`(one, other) -> whether the straight motion between two configurations is free`."""
_WORTH = 0.01
"""A shortcut that makes the path shorter by less than this part isn't worth its collision check."""
_PATIENCE = 18
_ROUNDS = 60


def interpolated(path: Path, resolution: float) -> Path:
    """Return the path with rows added so that no joint moves more than `resolution` [rad] between two."""
    pieces = [path[:1]]
    for one, other in zip(path[:-1], path[1:], strict=True):
        steps = max(1, int(np.ceil(np.abs(other - one).max() / resolution)))
        pieces.append(one + (other - one) * (np.arange(1, steps + 1) / steps)[:, None])
    return np.concatenate(pieces)


def at_arc(path: Path, where: Array) -> Path:
    """Return the configurations at distances along a path [rad], shape (m,) -> (m, n)."""
    at = arc(path)
    return np.stack([np.interp(where, at, column) for column in path.T], axis=1)


def arc(path: Path) -> Array:
    """Return how far along the path [rad] its rows are, joints weighted alike, shape (k,)."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])


def length(path: Path) -> float:
    """Return the length of a path [rad], joints weighted alike."""
    return float(arc(path)[-1])


def shortened(path: Path, edge_free: EdgeCheck, rng: np.random.Generator) -> Path:
    """Return a path with the same ends that is no longer.

    First every row that can be skipped is skipped, from the far end on; then random pairs of points on the path
    are joined where the straight motion is free (Geraerts and Overmars 2007). It ends after 60 rounds, or when
    a dozen in a row had nothing to gain, so the result depends on nothing but the arguments.
    """
    path, idle = _pruned(path, edge_free), 0
    for _ in range(_ROUNDS):
        if len(path) < 3 or idle >= _PATIENCE:
            break
        idle += 1
        at = arc(path)
        low, high = np.sort(rng.uniform(0.0, at[-1], 2))
        i, j = int(np.searchsorted(at, low, "right")) - 1, int(np.searchsorted(at, high, "right")) - 1
        if i == j:
            continue
        one, other = at_arc(path, np.array([low, high]))
        gain = high - low - float(np.linalg.norm(other - one))
        if gain > _WORTH * at[-1] and edge_free(one, other):
            idle = 0
            path = np.concatenate([path[: i + 1], [one, other], path[j + 1 :]])
    return _pruned(path, edge_free)


def _pruned(path: Path, edge_free: EdgeCheck) -> Path:
    rows, i = [0], 0
    while i < len(path) - 1:
        i = next((j for j in range(len(path) - 1, i + 1, -1) if edge_free(path[i], path[j])), i + 1)
        rows.append(i)
    return path[rows]


CONSTRAINT_SLACK = 0.02
"""Between its points a path is rounded into a spline; that may leave a constraint by this much [rad, m]."""
_DAMPING = 1e-6
_ROUNDS = 20
_MARGIN = 0.05
"""Projections aim this part inside the tolerances: a point on the very edge would be left by the next rounding."""


def excess(constraint: PathConstraint, chain: Chain, q: Array, shrunk: float = 0.0) -> tuple[Array, Array]:
    """Return what goes beyond the tolerances, and how that changes with the joints.

    Args:
        shrunk: part of the tolerances to take off.

    Returns:
        The excess, shape (m,) [rad, m], zero where a tolerance is kept, and its derivative, shape (m, n).
    """
    pin.computeJointJacobians(chain.model, chain.data, q)
    pin.updateFramePlacement(chain.model, chain.data, chain.frame)
    frame = chain.data.oMf[chain.frame]
    jacobian = pin.getFrameJacobian(chain.model, chain.data, chain.frame, pin.LOCAL)
    values, rows, allowed = [np.empty(0)], [np.empty((0, len(q)))], [np.empty(0)]
    if constraint.orientation is not None:
        wanted = constraint.orientation.rotation()
        about = wanted if constraint.axes == "world" else np.eye(3)
        relative = wanted.T @ frame.rotation
        values.append(about @ pin.log3(relative))
        rows.append(about @ pin.Jlog3(relative) @ jacobian[3:])
        allowed.append(np.array(constraint.tolerance))
    if constraint.box is not None:
        box = constraint.box.matrix()
        values.append(box[:3, :3].T @ (frame.translation - box[:3, 3]))
        rows.append(box[:3, :3].T @ frame.rotation @ jacobian[:3])
        allowed.append(np.array(constraint.size) / 2)
    value, limit = np.concatenate(values), np.concatenate(allowed) * (1 - shrunk)
    return np.sign(value) * np.maximum(np.abs(value) - limit, 0.0), np.concatenate(rows)


def kept(constraint: PathConstraint, chain: Chain, configurations: Array, slack: float = 1e-6) -> bool:
    """Tell whether all configurations, shape (k, n), keep to a constraint, up to `slack` [rad, m]."""
    return all(np.abs(excess(constraint, chain, q)[0]).max(initial=0.0) <= slack for q in configurations)


def projected(constraint: PathConstraint, chain: Chain, q: Array) -> Array | None:
    """Return a configuration near `q`, shape (n,), that keeps to a constraint, or None when none is found.

    Gauss-Newton steps on the excess, as in CBiRRT (Berenson et al. 2009).
    """
    for _ in range(_ROUNDS):
        beyond, jacobian = excess(constraint, chain, q, shrunk=_MARGIN)
        if np.abs(excess(constraint, chain, q)[0]).max(initial=0.0) == 0.0:
            return q
        active = beyond != 0
        rows = jacobian[active]
        step = -rows.T @ np.linalg.solve(rows @ rows.T + _DAMPING * np.eye(len(rows)), beyond[active])
        q = np.clip(q + step, chain.limits.lower, chain.limits.upper)
    return None
