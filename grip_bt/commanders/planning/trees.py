"""Two trees of configurations that grow towards one another until they meet: the frame of RRT-Connect and its kin.

After Kuffner and LaValle (2000). What a planner adds is how a tree is extended by one step: with projection it is
CBiRRT, with a transition test BiTRRT.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from grip_bt.base.arrays import Array, Configuration, Path


class Tree:
    """Configurations, each with the one that it was reached from."""

    def __init__(self, root: Configuration):
        self._rows = np.empty((64, len(root)))
        self._parents: list[int] = []
        self.add(root, -1)

    def __len__(self) -> int:
        return len(self._parents)

    def add(self, q: Configuration, parent: int) -> int:
        """Add a configuration and return its index."""
        index = len(self._parents)
        if index == len(self._rows):
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
        self._rows[index] = q
        self._parents.append(parent)
        return index

    def at(self, index: int) -> Configuration:
        """Return a configuration, shape (n,)."""
        return self._rows[index]

    def nearest(self, q: Configuration) -> int:
        """Return the index of the configuration nearest to `q`."""
        offsets = self._rows[: len(self)] - q
        return int(np.argmin(np.einsum("ij,ij->i", offsets, offsets)))

    def branch(self, index: int) -> Path:
        """Return the way from the root to a configuration, shape (k, n)."""
        rows = []
        while index >= 0:
            rows.append(self.at(index))
            index = self._parents[index]
        return np.stack(rows[::-1])


Extend = Callable[[Tree, int, Configuration], int | None]
"""`(tree, from, towards) -> index of the configuration that was added`, or None when there is no way on."""


def joined(
    start: Configuration,
    goals: Array,
    sample: Callable[[], Configuration],
    extend: Extend,
    over: Callable[[], bool],
    close: float = 1e-6,
) -> Path | None:
    """Return a way from `start` to one of the goals, shape (k, n), or None when time is over.

    Args:
        goals: shape (m, n).
        sample: returns random configurations to grow towards.
        extend: adds one step to a tree.
        over: asked after each step; True ends it.
        close: trees have met when they are this close, in every joint.
    """
    ours = Tree(start)
    theirs = [Tree(goal) for goal in goals]
    turn = 0
    while not over():
        other = theirs[turn % len(theirs)]
        forward = (turn // len(theirs)) % 2 == 0
        turn += 1
        growing, waiting = (ours, other) if forward else (other, ours)
        target = sample()
        reached = extend(growing, growing.nearest(target), target)
        if reached is None:
            continue
        meeting = grown_towards(waiting, growing.at(reached), extend, over, close)
        if meeting is not None:
            one, two = growing.branch(reached), waiting.branch(meeting)[::-1]
            return np.concatenate([one, two[1:]]) if forward else np.concatenate([one, two[1:]])[::-1]
    return None


def grown_towards(
    tree: Tree, target: Configuration, extend: Extend, over: Callable[[], bool], close: float
) -> int | None:
    """Extend a tree step by step as far as it goes; return the last index if that is the target."""
    index = tree.nearest(target)
    while not over():
        if np.abs(tree.at(index) - target).max() < close:
            return index
        step = extend(tree, index, target)
        if step is None:
            return None
        index = step
    return None


def stepped(one: Configuration, towards: Configuration, step: float) -> Configuration:
    """Return the configuration at most `step` [rad] (Euclidean) on the straight way from `one` to `towards`."""
    way = towards - one
    distance = float(np.linalg.norm(way))
    return np.array(towards) if distance <= step else one + way * (step / distance)
