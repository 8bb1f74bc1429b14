"""One tree by py_trees, its twin by the engine, tick by tick the same."""

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import contextmanager
from enum import Enum
from types import SimpleNamespace
from typing import Any

import py_trees
from engine_edits import edit
from engine_leaves import INVALID, Log
from engine_trees import Maker
from py_trees.behaviour import Behaviour

from grip_bt.runtime import TickEngine


@contextmanager
def quiet_world() -> Iterator[SimpleNamespace]:
    """py_trees without its error messages, on a clock that stands still between ticks, with a fresh blackboard."""
    world = SimpleNamespace(now=0.0)
    patch = __import__("pytest").MonkeyPatch()
    patch.setattr(py_trees.logging.Logger, "error", lambda self, message: None)
    patch.setattr(py_trees.decorators, "time", SimpleNamespace(monotonic=lambda: world.now))
    writer = py_trees.blackboard.Client(name="items")
    writer.register_key(key="items", access=py_trees.common.Access.WRITE)
    writer.items = [1, 2, 3]
    try:
        yield world
    finally:
        patch.undo()
        py_trees.blackboard.Blackboard.clear()
        py_trees.blackboard.Blackboard.clients.clear()


def state(root: Behaviour) -> list[tuple[Any, ...]]:
    """Everything of a tree that can be compared with its twin."""
    return [
        (
            {k: v for k, v in sorted(vars(node).items()) if isinstance(v, (int, float, str, Enum, type(None)))},
            getattr(getattr(node, "current_child", None), "name", None),
            getattr(node.tip(), "name", None),
        )
        for node in root.iterate()
    ]


class Pair:
    """Twin trees from one seed."""

    def __init__(self, seed: int, *, calm: bool = False, wild: bool = True, **engine: Any):
        self.logs = Log("one"), Log("other")
        self.trees = [Maker(seed, log, calm=calm, wild=wild).tree(3 if seed % 3 else 4) for log in self.logs]
        self.engine = TickEngine(self.trees[1], **engine)

    def tick(self) -> str | None:
        """Tick both; return how they differ."""
        return self._both(self.trees[0].tick_once, self.engine.tick)

    def halt(self) -> str | None:
        """Stop both; return how they differ."""
        return self._both(lambda: self.trees[0].stop(INVALID), self.engine.halt)

    def edit(self, seed: int, fixed: bool) -> str | None:
        """Do the same to both; return how they differ."""
        first, second = self.trees
        return self._both(
            lambda: edit(first, seed, self.logs[0], fixed=fixed),
            lambda: edit(second, seed, self.logs[1], fixed=fixed),
        )

    def _both(self, theirs: Any, ours: Any) -> str | None:
        raised = [_outcome(theirs), _outcome(ours)]
        found = {
            "raised": raised,
            "callbacks": self.logs,
            "state": [state(tree) for tree in self.trees],
        }
        for what, (left, right) in found.items():
            if left != right:
                return f"{what} differ\n  py_trees: {_tail(left, right)}\n  engine:   {_tail(right, left)}"
        for log in self.logs:
            log.clear()
        return None


def _outcome(action: Any) -> str | None:
    try:
        action()
    except RecursionError:
        raise
    except Exception as error:  # noqa: BLE001 - whatever it is, the other side has to raise the same
        return repr(error).replace("/one/", "/").replace("/other/", "/")  # each tree has its part of the blackboard
    return None


def _tail(left: Any, right: Any) -> Any:
    if not isinstance(left, list):
        return left
    first = next((i for i, (a, b) in enumerate(zip(left, right, strict=False)) if a != b), min(len(left), len(right)))
    return f"from item {first}: {left[first : first + 4]}"


def compare(seed: int, ticks: int = 8, edits: float = 0.3, fixed: bool = False, **options: Any) -> str | None:
    """Tick twin trees, with edits in between, of statuses only where they are fixed; return how they differ."""
    rng = random.Random(seed + 1)
    with quiet_world() as world:
        pair = Pair(seed, fixed=fixed, **options)
        for tick in range(ticks):
            world.now += 1.0
            found = pair.tick()
            if found is None and rng.random() < edits:
                found = pair.halt() if rng.random() < 0.2 else pair.edit(rng.randrange(10**6), fixed)
            if found is not None:
                tree = py_trees.display.unicode_tree(pair.trees[0], show_status=True)
                return f"seed {seed}, tick {tick}: {found}\n{tree}"
    return None
