"""Which rules a node of a tree follows: those of py_trees, ours, or its own.

A node is compiled only when its `tick` and `stop` are known to the letter. py_trees' methods are remembered as they
were when this module was imported: a class that has been patched since is a stranger.
"""

from __future__ import annotations

from enum import Enum, auto
from typing import Any

from py_trees import behaviours, composites, decorators
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.nodes.container import KindNode
from grip_bt.nodes.leaf import Leaf
from grip_bt.nodes.node import Conditional, Node

S, F, R, INVALID = Status.SUCCESS, Status.FAILURE, Status.RUNNING, Status.INVALID
VALID = tuple(Status)


class Rules(Enum):
    """How a node is ticked."""

    LEAF = auto()
    SEQUENCE = auto()
    SELECTOR = auto()
    PARALLEL = auto()
    DECORATOR = auto()
    KIND = auto()
    """Containers whose kind is an automaton."""
    OWN = auto()
    """By its own generator."""


_KNOWN = {
    Behaviour.tick: (Rules.LEAF, Behaviour.stop),
    composites.Sequence.tick: (Rules.SEQUENCE, composites.Sequence.stop),
    composites.Selector.tick: (Rules.SELECTOR, composites.Selector.stop),
    composites.Parallel.tick: (Rules.PARALLEL, composites.Parallel.stop),
    decorators.Decorator.tick: (Rules.DECORATOR, decorators.Decorator.stop),
}
_LEAF_TICK, _OURS_STOP = Leaf.tick, Node.stop
_KIND_STOPS = {
    each.stop for each in (composites.Composite, composites.Sequence, composites.Selector, composites.Parallel)
} | {decorators.Decorator.stop}
_KIND_TICK = KindNode.tick
_CONDITIONAL = Conditional.tick
_PLAIN = {
    "initialise": (Behaviour.initialise,),
    "terminate": (Behaviour.terminate, behaviours.StatusQueue.terminate),  # which writes a debug message
    "validate_policy_configuration": (composites.Parallel.validate_policy_configuration,),
}
LIFE_CYCLE = frozenset({"tick", "stop", *_PLAIN})
"""Methods whose replacement changes how a node is compiled; others are looked up at each call."""


def rules_of(node: Behaviour) -> Rules:
    """Return the rules that the node follows; OWN for everything that isn't known to the letter."""
    cls: Any = type(node)
    if _replaced_on(node, "tick") or _replaced_on(node, "stop"):
        return Rules.OWN
    tick, stop = cls.tick, cls.stop
    if issubclass(cls, KindNode):
        if tick is _CONDITIONAL:
            tick = _after(cls, Conditional, "tick")
        known = tick is _KIND_TICK and stop is _OURS_STOP and _after(cls, Node, "stop") in _KIND_STOPS
        return Rules.KIND if known else Rules.OWN
    if issubclass(cls, Node):
        if tick is _CONDITIONAL:
            tick = _after(cls, Conditional, "tick")
        if tick is not _LEAF_TICK or stop is not _OURS_STOP:
            return Rules.OWN
        tick, stop = _after(cls, Leaf, "tick"), _after(cls, Node, "stop")
    rules, known_stop = _KNOWN.get(tick, (Rules.OWN, None))
    if stop is not known_stop or (rules is Rules.LEAF and isinstance(node, composites.Composite)):
        return Rules.OWN
    return rules


def children_of(node: Any, rules: Rules) -> list[Behaviour]:
    """Return the children that the node ticks."""
    return [node.decorated] if rules is Rules.DECORATOR else list(node.children)


def regular(node: object, rules: Rules) -> bool:
    """Tell whether the children can be compiled too: each is there once, and ours has ours alone."""
    if rules in (Rules.LEAF, Rules.OWN):
        return True
    kids = children_of(node, rules)
    if len(set(map(id, kids))) != len(kids):
        return False
    return rules is not Rules.KIND or all(map(ours, kids))


def ours(node: Behaviour) -> bool:
    """Tell whether the node reports to observers and has labelled ends."""
    return isinstance(node, Node)


def overrides(node: Behaviour, name: str) -> bool:
    """Tell whether such a method does more than those of py_trees that need not be called."""
    return _replaced_on(node, name) or getattr(type(node), name) not in _PLAIN[name]


def _replaced_on(node: Behaviour, name: str) -> bool:
    """Tell whether the instance has a method of its own. Doesn't ask for `__dict__`, which would slow the node down."""
    method = getattr(node, name)
    return getattr(method, "__func__", None) is not getattr(type(node), name) or method.__self__ is not node


def _after(cls: type, mixin: type, name: str) -> Any:
    """Return what `super().name` means in `mixin` for instances of `cls`."""
    line = cls.__mro__
    for base in line[line.index(mixin) + 1 :]:
        if name in vars(base):
            return vars(base)[name]
    return None
