"""Which rules a node of a tree follows: those of py_trees, ours, or its own.

A node is compiled only when its `tick` and `stop` are known to the letter. py_trees' methods are remembered as they
were when this module was imported: a class that has been patched since is a stranger.
"""

from __future__ import annotations

from enum import Enum, auto
from typing import Any

from py_trees import behaviours, composites, decorators
from py_trees.behaviour import Behaviour

from grip_bt.nodes.control.chooser import _Turns
from grip_bt.nodes.control.condition import Conditional
from grip_bt.nodes.control.container import Container
from grip_bt.nodes.control.dispatch import _Steps
from grip_bt.nodes.control.guard import _Gate
from grip_bt.nodes.control.parallel import _Rounds
from grip_bt.nodes.leaf import Leaf
from grip_bt.nodes.node import Node


class Kind(Enum):
    """How a node is ticked."""

    LEAF = auto()
    SEQUENCE = auto()
    SELECTOR = auto()
    PARALLEL = auto()
    DECORATOR = auto()
    ROUNDS = auto()
    """Our parallel."""
    STEPS = auto()
    """Our state machine."""
    TURNS = auto()
    """Our switch, loop, for_each and cooldown."""
    GATE = auto()
    """Our guard and our timeout."""
    FOREIGN = auto()
    """By its own generator."""


LIFE_CYCLE = ("tick", "stop", "initialise", "terminate", "validate_policy_configuration")
"""Methods whose replacement changes how a node is compiled; `update` is looked up at each call."""

_TICKS = {
    Behaviour.tick: Kind.LEAF,
    composites.Sequence.tick: Kind.SEQUENCE,
    composites.Selector.tick: Kind.SELECTOR,
    composites.Parallel.tick: Kind.PARALLEL,
    decorators.Decorator.tick: Kind.DECORATOR,
    _Rounds.tick: Kind.ROUNDS,
    _Steps.tick: Kind.STEPS,
    _Turns.tick: Kind.TURNS,
    _Gate.tick: Kind.GATE,
}
_COMPOSITE = composites.Composite.stop
_STOPS = {
    Kind.LEAF: {Behaviour.stop},
    Kind.SEQUENCE: {composites.Sequence.stop},
    Kind.SELECTOR: {composites.Selector.stop},
    Kind.PARALLEL: {composites.Parallel.stop},
    Kind.DECORATOR: {decorators.Decorator.stop},
    Kind.ROUNDS: {composites.Parallel.stop},
    Kind.STEPS: {_COMPOSITE},
    Kind.TURNS: {_COMPOSITE},
    Kind.GATE: {decorators.Decorator.stop},
}
_OURS_TICK = {Container: Container.tick, Leaf: Leaf.tick}
_OURS_STOP = Node.stop
_CONDITIONAL = Conditional.tick
DECORATORS = (Kind.DECORATOR, Kind.GATE)
_VALIDATION = composites.Parallel.validate_policy_configuration
_PLAIN = {
    "initialise": (Behaviour.initialise,),
    "terminate": (Behaviour.terminate, behaviours.StatusQueue.terminate),  # which writes a debug message
}


def overrides(node: Behaviour, name: str) -> bool:
    """Tell whether `initialise` or `terminate` does more than those of py_trees that do nothing."""
    return replaced_on(node, name) or getattr(type(node), name) not in _PLAIN[name]


def plain_validation(node: Behaviour) -> bool:
    """Tell whether a parallel looks at its policy as py_trees does."""
    name = "validate_policy_configuration"
    return not replaced_on(node, name) and getattr(type(node), name) is _VALIDATION


def replaced_on(node: Behaviour, name: str) -> bool:
    """Tell whether the instance has a method of its own. Doesn't ask for `__dict__`, which would slow the node down."""
    method = getattr(node, name)
    return getattr(method, "__func__", None) is not getattr(type(node), name) or method.__self__ is not node


def ours(node: Behaviour) -> bool:
    """Tell whether the node reports to observers and has labelled ends."""
    return isinstance(node, Node)


def conditional(node: Behaviour) -> bool:
    """Tell whether a node of ours looks at a precondition before it begins."""
    return isinstance(node, Conditional)


def kind_of(node: Behaviour) -> Kind:
    """Return the rules that the node follows; FOREIGN for everything that isn't known to the letter."""
    cls: Any = type(node)
    if replaced_on(node, "tick") or replaced_on(node, "stop"):
        return Kind.FOREIGN
    tick, stop = cls.tick, cls.stop
    if issubclass(cls, Node):
        mixin = Leaf if issubclass(cls, Leaf) else Container
        if tick is _CONDITIONAL:
            tick = _after(cls, Conditional, "tick")
        if tick is not _OURS_TICK[mixin] or stop is not _OURS_STOP:
            return Kind.FOREIGN
        tick, stop = _after(cls, mixin, "tick"), _after(cls, Node, "stop")
    kind = _TICKS.get(tick, Kind.FOREIGN)
    if kind is Kind.FOREIGN or stop not in _STOPS[kind]:
        return Kind.FOREIGN
    if kind is Kind.LEAF and isinstance(node, composites.Composite):
        return Kind.FOREIGN
    return kind


def _after(cls: type, mixin: type, name: str) -> Any:
    """Return what `super().name` means in `mixin` for instances of `cls`."""
    line = cls.__mro__
    for base in line[line.index(mixin) + 1 :]:
        if name in vars(base):
            return vars(base)[name]
    return None
