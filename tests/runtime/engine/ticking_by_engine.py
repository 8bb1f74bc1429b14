"""A plug-in for pytest that has tick engines do every tick of py_trees' own tests, and says how many there were."""

from __future__ import annotations

import collections
from typing import Any
from weakref import WeakKeyDictionary

import py_trees
from py_trees.behaviour import Behaviour

from grip_bt.runtime import TickEngine

used: collections.Counter[str] = collections.Counter()
engines: WeakKeyDictionary[Behaviour, TickEngine] = WeakKeyDictionary()


def tick_once(self: Behaviour) -> None:
    """Tick by an engine that is kept from tick to tick, as an application would."""
    used["tick_once"] += 1
    if self not in engines:
        engines[self] = TickEngine(self)
    engines[self].tick()


def tick(self: Any, pre_tick_handler: Any = None, post_tick_handler: Any = None) -> None:
    """`BehaviourTree.tick`, with the root ticked by an engine."""
    used["BehaviourTree.tick"] += 1
    if pre_tick_handler is not None:
        pre_tick_handler(self)
    for handler in self.pre_tick_handlers:
        handler(self)
    for visitor in self.visitors:
        visitor.initialise()

    for node in self.root.tick():  # whoever visits nodes as they are ticked has py_trees tick
        for visitor in self.visitors:
            if not visitor.full:
                node.visit(visitor)
    for node in self.root.iterate():
        for visitor in self.visitors:
            if visitor.full:
                node.visit(visitor)
    for visitor in self.visitors:
        visitor.finalise()
    for handler in self.post_tick_handlers:
        handler(self)
    if post_tick_handler is not None:
        post_tick_handler(self)
    self.count += 1


def tick_tree(root: Behaviour, from_tick: int, to_tick: int, *, visitors: Any = None, **shown: Any) -> None:
    """`py_trees.tests.tick_tree`, by one engine."""
    for _ in range(from_tick, to_tick + 1):
        used["tick_tree"] += 1
        for visitor in visitors or []:
            visitor.initialise()
        for node in root.tick():
            for visitor in visitors or []:
                node.visit(visitor)


Behaviour.tick_once = tick_once  # type: ignore[method-assign]
py_trees.trees.BehaviourTree.tick = tick  # type: ignore[method-assign]
py_trees.tests.tick_tree = tick_tree


def pytest_sessionfinish(session: Any) -> None:
    """Say how often an engine ticked."""
    print(f"\nticks by engines: {sum(used.values())} {dict(used)}")  # noqa: T201 - read by the test that starts this
