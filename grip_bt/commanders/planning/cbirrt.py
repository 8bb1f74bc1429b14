"""CBiRRT: two trees whose every step is projected onto what the path must keep to (Berenson et al. 2009)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from grip_bt.base.arrays import Array, Configuration, Path
from grip_bt.base.values import PathConstraint

from ..collision import CollisionChecker
from .constraints import kept, projected
from .paths import EdgeCheck, interpolated, length
from .trees import Tree, grown_towards, joined, stepped

STEP = 0.15
"""Longest step before its projection [rad]."""
_ROUNDS = 60
_SAMPLING = 0.03


def cbirrt(
    checker: CollisionChecker,
    edge_free: EdgeCheck,
    constraint: PathConstraint,
    start: Configuration,
    goal: Configuration,
    rng: np.random.Generator,
    over: Callable[[], bool],
) -> Path | None:
    """Return a short free way that keeps to a constraint, shape (k, n), or None when `over` says so."""
    chain = checker.chain

    def extend(tree: Tree, index: int, towards: Configuration) -> int | None:
        one = tree.at(index)
        other = projected(constraint, chain, stepped(one, towards, STEP))
        # A projection may slide back; then the tree would grow on the spot for ever.
        if other is None or np.linalg.norm(towards - other) >= np.linalg.norm(towards - one):
            return None
        edge = np.stack([one, other])
        if not kept(constraint, chain, interpolated(edge, _SAMPLING), slack=1e-3) or not edge_free(one, other):
            return None
        return tree.add(other, index)

    limits = chain.limits
    path = joined(start, goal[None, :], lambda: rng.uniform(limits.lower, limits.upper), extend, over, close=1e-3)
    return None if path is None else _shortened(path, extend, rng, over)


def _shortened(
    path: Path,
    extend: Callable[[Tree, int, Configuration], int | None],
    rng: np.random.Generator,
    over: Callable[[], bool],
) -> Path:
    """Replace parts of the path by what one tree grows from their beginning to their end, where that is shorter."""
    for _ in range(_ROUNDS):
        if len(path) < 3 or over():
            break
        i, j = np.sort(rng.choice(len(path), 2, replace=False))
        tree = Tree(path[i])
        end = grown_towards(tree, path[j], extend, over, close=1e-3) if j > i + 1 else None
        if end is not None:
            piece: Array = np.concatenate([tree.branch(end)[:-1], path[j : j + 1]])
            if length(piece) < length(path[i : j + 1]):
                path = np.concatenate([path[:i], piece, path[j + 1 :]])
    return path
