"""Ways to search for a path that were tried beside OMPL's RRTConnect with batched edges; see `plan_ways.py`.

Each is called as `planning.free._solved` is, and returns a path, shape (k, n), or None.
"""

from __future__ import annotations

import heapq
import time
from collections.abc import Callable
from typing import Any
from unittest import mock

import numpy as np
import ompl.base as ob
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from grip_bt.commanders.kinematics.collision import CollisionChecker
from grip_bt.commanders.planning import search
from grip_bt.commanders.planning.search import MotionCheck, halving
from grip_bt.commanders.planning.tree_planners import Tree, joined, stepped

Array = NDArray[np.float64]
REACH = 0.65
"""Longest step of a tree [rad]."""


def own_range(*arguments: Any) -> Array | None:
    """OMPL's RRTConnect with the range that it takes by itself, a fifth of the space's diagonal."""
    with mock.patch.object(search, "_STEP", 0.0):
        return SOLVED(*arguments)


def one_by_one(*arguments: Any) -> Array | None:
    """OMPL's RRTConnect with a callback for each state of an edge, halving, at the same resolution."""

    def setup(information: ob.SpaceInformation, motion_free: MotionCheck, _: int) -> ob.MotionValidator:
        extent = information.getStateSpace().getMaximumExtent()
        information.setStateValidityCheckingResolution(motion_free.resolution / extent)
        return information.getMotionValidator()  # the default

    with mock.patch.object(search, "_MotionValidator", setup):
        return SOLVED(*arguments)


SOLVED = search._solved


def own_trees(
    checker: CollisionChecker, motion_free: MotionCheck, start: Array, goal: Array, _: str, seed: int, *__: Any
) -> Array | None:
    """RRT-Connect in Python: no callback, the same batched edges."""
    sample = _sampler(checker, seed)

    def extend(tree: Tree, at: int, target: Array) -> int | None:
        there = stepped(tree.at(at), target, REACH)
        return tree.add(there, at) if motion_free(tree.at(at), there) else None

    return joined(start, goal, sample, extend, _out_of_time())


def lazy_trees(
    checker: CollisionChecker, motion_free: MotionCheck, start: Array, goal: Array, _: str, seed: int, *__: Any
) -> Array | None:
    """Two trees whose nodes are checked when they are added, edges only when they join the trees (SBL's way)."""
    sample, over = _sampler(checker, seed), _out_of_time()
    trees = [_Lazy(start), _Lazy(goal)]
    turn = 0
    while not over():
        growing, waiting = trees[turn % 2], trees[1 - turn % 2]
        at = growing.nearest(target := sample())
        there = stepped(growing.rows[at], target, REACH)
        if turn:  # the first question is whether a straight line would do; that was asked before
            if not checker.free(there):
                turn += 1
                continue
            at = growing.add(there, at)
        turn += 1
        meeting = waiting.nearest(growing.rows[at])
        one, other = growing.branch(at), waiting.branch(meeting)
        path = np.stack([growing.rows[k] for k in one] + [waiting.rows[k] for k in reversed(other)])
        bad = first_broken(checker, motion_free.resolution, path, _known(growing, one, waiting, other))
        if bad is None:
            return path if growing is trees[0] else path[::-1]
        if bad < len(one) - 1:
            growing.cut(one[bad + 1])
        elif bad > len(one) - 1:
            waiting.cut(other[len(path) - 1 - bad])
    return None


class _Lazy:
    """A tree whose branches can be cut off."""

    def __init__(self, root: Array):
        self.rows: list[Array] = [root]
        self.parents: list[int] = [-1]
        self.alive: list[bool] = [True]
        self.checked: set[int] = set()

    def add(self, q: Array, parent: int) -> int:
        self.rows.append(q)
        self.parents.append(parent)
        self.alive.append(True)
        return len(self.rows) - 1

    def nearest(self, q: Array) -> int:
        offsets = np.array(self.rows) - q
        distance = np.einsum("ij,ij->i", offsets, offsets)
        return int(np.argmin(np.where(self.alive, distance, np.inf)))

    def branch(self, index: int) -> list[int]:
        """Return the nodes from the root to one."""
        nodes = []
        while index >= 0:
            nodes.append(index)
            index = self.parents[index]
        return nodes[::-1]

    def cut(self, index: int) -> None:
        """Take off a node and all that was reached from it."""
        gone = {index}
        for k in range(index, len(self.rows)):
            if self.parents[k] in gone or k == index:
                gone.add(k)
                self.alive[k] = False


def _known(growing: _Lazy, one: list[int], waiting: _Lazy, other: list[int]) -> list[tuple[set[int], int] | None]:
    """Return, for each edge from root to root, where it is written down that it is free."""
    theirs = [(waiting.checked, k) for k in reversed(other[1:])]
    return [*((growing.checked, k) for k in one[1:]), None, *theirs]


def first_broken(
    checker: CollisionChecker, resolution: float, path: Array, known: list[tuple[set[int], int] | None]
) -> int | None:
    """Look at the unknown edges of a path, all at once, coarse steps first; return one that isn't free."""
    edges = [k for k, mark in enumerate(known) if mark is None or mark[1] not in mark[0]]
    rows, depth = [], []
    for k in edges:
        way = path[k + 1] - path[k]
        fractions = halving(max(1, int(np.ceil(np.abs(way).max() / resolution))))
        rows.append(path[k] + way * fractions[:, None])
        depth.append(np.log2(np.arange(1, len(fractions) + 1)).astype(int))
    owner = np.repeat(edges, [len(r) for r in rows])
    order = np.argsort(np.concatenate(depth), kind="stable") if edges else np.empty(0, int)
    all_rows = np.concatenate(rows)[order] if edges else np.empty((0, path.shape[1]))
    owner = owner[order]
    for begin in range(0, len(all_rows), 24):
        part = all_rows[begin : begin + 24]
        if not checker.all_free(part):
            return int(owner[begin + int(np.argmin(checker.free_each(part)))])
    for k in edges:
        mark = known[k]
        if mark is not None:
            mark[0].add(mark[1])
    return None


class Roadmap:
    """LazyPRM*: nodes that the robot alone is free in, made once; edges looked at when a way leads over them.

    Args:
        alone: checks the robot against itself.
        count: nodes.
        neighbours: edges of each, about.
    """

    def __init__(self, alone: CollisionChecker, count: int = 1500, neighbours: int = 12, seed: int = 0):
        limits, rng = alone.chain.limits, np.random.default_rng(seed)
        found: list[Array] = []
        while len(found) < count:
            q = rng.uniform(limits.lower, limits.upper, (256, len(limits.lower)))
            found.extend(q[alone.free_each(q)])
        self.nodes = np.array(found[:count])
        self.tree = cKDTree(self.nodes)
        _, near = self.tree.query(self.nodes, neighbours + 1)
        pairs = {(min(a, b), max(a, b)) for a, row in enumerate(near.tolist()) for b in row[1:]}
        self.edges: list[list[tuple[int, float]]] = [[] for _ in found[:count]]
        for a, b in sorted(pairs):
            length = float(np.linalg.norm(self.nodes[a] - self.nodes[b]))
            self.edges[a].append((b, length))
            self.edges[b].append((a, length))
        self.free: dict[Any, bool] = {}
        """Of the present scene: node or edge -> whether it is free, as far as it was looked at."""

    def __call__(
        self, checker: CollisionChecker, motion_free: MotionCheck, start: Array, goal: Array, *_: Any
    ) -> Array | None:
        """Search as `planning.free._solved` does."""
        over, status = _out_of_time(), dict[Any, bool]()
        resolution, places = motion_free.resolution, {-1: start, -2: goal}
        ends = {k: self.tree.query(q, 16) for k, q in places.items()}
        to_goal = dict(zip(ends[-2][1].tolist(), ends[-2][0].tolist(), strict=True))
        to_goal[-1] = float(np.linalg.norm(goal - start))
        left = np.linalg.norm(self.nodes - goal, axis=1)

        def known(key: Any) -> bool | None:
            mine = status if min(key if isinstance(key, tuple) else (key,)) < 0 else self.free
            return mine.get(key)

        def following(k: int) -> list[tuple[int, float]]:
            near = zip(ends[-1][1].tolist(), ends[-1][0].tolist(), strict=True)
            out = list(near) if k == -1 else list(self.edges[k])
            return [*out, (-2, to_goal[k])] if k in to_goal else out

        while not over():
            way = _shortest(following, known, left)
            if way is None:
                return None
            path = np.array([places[k] if k < 0 else self.nodes[k] for k in way])
            unknown = [k for k in way[1:-1] if k not in self.free]
            if unknown:
                touching = ~checker.free_each(self.nodes[unknown])
                self.free |= dict(zip(unknown, (~touching).tolist(), strict=True))
                if touching.any():
                    continue
            keys = [(min(a, b), max(a, b)) for a, b in zip(way, way[1:], strict=False)]
            marks = [(set(), 0) if known(key) is None else ({0}, 0) for key in keys]
            bad = first_broken(checker, resolution, path, marks)  # type: ignore[arg-type]
            for k, key in enumerate(keys):
                if bad == k or (bad is None and known(key) is None):
                    (status if min(key) < 0 else self.free)[key] = bad is None
            if bad is None:
                return path
        return None


def _shortest(
    following: Callable[[int], list[tuple[int, float]]], known: Callable[[Any], bool | None], left: Array
) -> list[int] | None:
    """A* from -1 to -2 over all that isn't known to touch something."""
    queue, best, before = [(0.0, 0.0, -1)], {-1: 0.0}, dict[int, int]()
    while queue:
        _, cost, k = heapq.heappop(queue)
        if k == -2:
            way = [k]
            while way[-1] != -1:
                way.append(before[way[-1]])
            return way[::-1]
        if cost > best[k]:
            continue
        for other, length in following(k):
            longer = cost + length
            if longer >= best.get(other, np.inf):
                continue
            if known(other) is False or known((min(k, other), max(k, other))) is False:
                continue
            best[other], before[other] = longer, k
            rest = 0.0 if other < 0 else float(left[other])
            heapq.heappush(queue, (longer + rest, longer, other))
    return None


def _sampler(checker: CollisionChecker, seed: int) -> Callable[[], Array]:
    limits, rng = checker.chain.limits, np.random.default_rng(seed)
    return lambda: rng.uniform(limits.lower, limits.upper)


def _out_of_time(seconds: float = 2.0) -> Callable[[], bool]:
    end = time.monotonic() + seconds
    return lambda: time.monotonic() > end
