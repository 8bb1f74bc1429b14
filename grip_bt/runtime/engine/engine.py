"""A tree of py_trees, ticked without its generators, with nothing else to see."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Sequence
from functools import partial
from operator import attrgetter
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Composite

from grip_bt.base.errors import NodeError
from grip_bt.nodes.container import KindNode
from grip_bt.nodes.node import Conditional
from grip_bt.task.kinds.base import Run

from . import theirs
from .halting import Compiled, Stop, Tick, halt_all, make_stop
from .known import INVALID, LIFE_CYCLE, F, R, Rules, S, children_of, ours, overrides, regular, rules_of
from .theirs import Verdict, checked


def our_leaf(node: Any, stop: Stop) -> Tick:
    """`Leaf.tick`: an activation is reported, and what `update` raises becomes a NodeError."""
    initialises = overrides(node, "initialise")

    def tick() -> Status:
        try:
            if node.status is not R:
                node.inputs_read = {}
                node.begin()
                if initialises:
                    node.initialise()
            status = checked(node, node.update())
            if status is not R:
                stop(status)
            node.status = status
            if status is INVALID:
                raise TypeError("update() has to return SUCCESS, FAILURE or RUNNING")
        except Exception as error:
            node._abandon(error)
            raise NodeError(node.path, error) from error
        return status

    return tick


def conditional(node: Any, inner: Tick) -> Tick:
    """`Conditional.tick`: look at the precondition before an activation begins."""

    def tick() -> Status:
        return F if node.status is not R and node.refused() else inner()

    return tick


def automaton(node: Any, parts: Sequence[Compiled], stop: Stop) -> Tick:
    """The tick of a container, whatever its kind: `KindNode.tick`, without its generators."""
    kids, ticks, kind = [part.node for part in parts], [part.tick for part in parts], node.kind
    reset = partial(halt_all, parts)
    reactive, patient, again = kind.reactive, kind.concurrent or not kind.settles, kind.again

    def tick() -> Status:
        before, step = node.running, None
        if node.status is not R or node.resting or not before:
            step, before = node.opening(reset), node.running
        elif reactive:
            step = again(node.state, before, node.answers)
        while step is None or type(step) is Run:
            if step is None:
                run = before
            elif step[0] == before and not kind.concurrent:
                run, node.state = before, step[1]
            else:
                run = node.run(step)
            step, going = None, patient and run is before
            for i in run:
                if ticks[i]() is not R:
                    going = False
                    step = node.after(i, kids[i])
                    if step is not None:
                        break
            if going:
                node.status = R
                return R
            if step is None:
                step = node.ticked(run)
        node.land(step, stop)
        return node.status

    return tick


_LEVELS = 150
"""What is deeper is left to py_trees, whose generators go deeper than functions that call functions."""

_TO_EXHAUSTION = Verdict()
_VERDICTS = {
    Rules.SEQUENCE: Verdict(leave=(F, R, INVALID), onward=S),
    Rules.SELECTOR: Verdict(leave=(R, S), onward=F),
}


class TickEngine:
    """Ticks a tree as `root.tick_once()` does, only faster.

    Whoever looks at the tree after a tick sees what py_trees would have left: statuses, feedback messages, current
    children, tips; the nodes' callbacks are called in the same order and see the same. The tree may be edited between
    ticks: it is looked through before each one, and compiled again when something has changed.

    Args:
        root: any behaviour of py_trees.
        fixed: a promise that the tree isn't edited and no method of a node or of its class replaced while the engine is
            in use, which spares looking for it.
    """

    def __init__(self, root: Behaviour, *, fixed: bool = False):
        self.root = root
        self._fixed = fixed
        self._compile()

    def tick(self) -> None:
        """Do what `root.tick_once()` does.

        Raises:
            Exception: what a node raises, as it is; the tree is left as py_trees leaves it.
        """
        if not self._fixed and self._changed():
            self._compile()
        self._tick()

    def halt(self) -> None:
        """Do what `root.stop(Status.INVALID)` does."""
        self.root.stop(INVALID)

    def _compile(self) -> None:
        nodes: list[Behaviour] = []
        self._tick = _compiled(self.root, nodes).tick
        if not self._fixed:
            self._changed = _watch(nodes)


def make_ticker(node: Behaviour) -> Callable[[], object]:
    """Return what does `node.tick_once()`; nobody may replace methods of the nodes or edit them from now on."""
    return _compiled(node, []).tick


def _compiled(node: Any, nodes: list[Behaviour], verdict: Verdict = _TO_EXHAUSTION, level: int = 0) -> Compiled:
    """Return the compiled node, bottom up; what isn't known to the letter is ticked and stopped by py_trees.

    Args:
        nodes: gets all that is looked at.
        level: how far down it is.
    """
    nodes.append(node)
    rules = rules_of(node)
    if rules is Rules.OWN or level > _LEVELS or not regular(node, rules):
        return Compiled(node, theirs.by_generator(node, verdict), node.stop)
    below = _VERDICTS.get(rules, _TO_EXHAUSTION)
    parts = [_compiled(kid, nodes, below, level + 1) for kid in children_of(node, rules)]
    stop = make_stop(node, rules, parts)
    tick = _ticking(node, rules, parts, stop)
    if isinstance(node, Conditional):
        tick = conditional(node, tick)
    plain = rules is Rules.LEAF and not (ours(node) or overrides(node, "initialise") or overrides(node, "terminate"))
    return Compiled(node, tick, stop, plain)


def _ticking(node: Any, rules: Rules, parts: list[Compiled], stop: Stop) -> Tick:
    match rules:
        case Rules.LEAF:
            return our_leaf(node, stop) if ours(node) else theirs.leaf(node)
        case Rules.SEQUENCE:
            return theirs.sequence(node, parts, stop)
        case Rules.SELECTOR:
            return theirs.selector(node, parts, stop)
        case Rules.PARALLEL:
            return theirs.parallel(node, parts, stop)
        case Rules.DECORATOR:
            return theirs.decorator(node, parts[0], stop)
    return automaton(node, parts, stop)


def _watch(nodes: list[Any]) -> Callable[[], bool]:
    """Return what tells whether nodes have other children or settings, or they or their classes other methods.

    A method that is assigned to an instance makes its attributes more.
    """
    composites = [node for node in nodes if isinstance(node, Composite)]
    looks = [
        (attrgetter("children"), composites),
        (attrgetter("memory"), [node for node in composites if hasattr(node, "memory")]),
        (attrgetter("decorated"), [node for node in nodes if hasattr(node, "decorated")]),
        (attrgetter("kind"), [node for node in nodes if isinstance(node, KindNode)]),
        *((attrgetter(*(name for name in LIFE_CYCLE if hasattr(cls, name))), [cls]) for cls in set(map(type, nodes))),
    ]
    was: list[list[object]] = [[list(at) if isinstance(at, list) else at for at in map(get, of)] for get, of in looks]
    attributes = [_attributes(node) for node in nodes]
    sizes = [*map(len, attributes)]
    owned = [LIFE_CYCLE & own.keys() for own in attributes]

    def changed() -> bool:
        if any([*map(get, of)] != before for (get, of), before in zip(looks, was, strict=True)):
            return True
        if [*map(len, attributes)] != sizes:
            sizes[:] = map(len, attributes)
            return [LIFE_CYCLE & own.keys() for own in attributes] != owned
        return False

    return changed


_unshared: dict[int, weakref.ref[Behaviour]] = {}


def _attributes(node: Behaviour) -> dict[str, object]:
    """Return the node's attributes, in a dictionary of their own.

    Asking for `__dict__` makes CPython 3.11 and 3.12 give up the instance's compact form for one that shares its keys
    with other instances, in which reading and writing attributes is slow. Plain dictionaries are fast. Each node gets
    one once, since whoever watches holds on to it.
    """
    key = id(node)
    known = _unshared.get(key)
    if known is None or known() is not node:
        node.__dict__ = dict(vars(node))
        _unshared[key] = weakref.ref(node, lambda _: _unshared.pop(key, None))
    attributes: dict[str, object] = vars(node)
    return attributes
