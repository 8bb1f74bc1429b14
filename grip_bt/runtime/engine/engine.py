"""A tree of py_trees, ticked without its generators, with nothing else to see."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.nodes.condition import Conditional

from . import composites, containers
from .composites import Look
from .guard import Methods, watch, watch_all, watch_classes
from .halting import NOTHING, Compiled, Reset, Stop, Tick, make_halt, make_reset, make_stop, silent
from .known import INVALID, F, R, Rules, S, children_of, deeper_than, ours, regular, rules_of
from .leaves import Verdict, by_generator, leaf, only_updates, our_leaf

_LEVELS = 150
"""Trees with more of them are left to py_trees, whose generators go deeper than functions that call functions."""

_TO_EXHAUSTION = Verdict()
_VERDICTS = {
    Rules.SEQUENCE: Verdict(leave=(F, R, INVALID), onward=S),
    Rules.SELECTOR: Verdict(leave=(R, S), onward=F),
}

Visit = Callable[[Behaviour], None]


class TickEngine:
    """Ticks a tree as `root.tick_once()` does, only faster.

    Whoever looks at the tree after a tick sees what py_trees would have left: statuses, feedback messages, current
    children, tips; the nodes' callbacks are called in the same order and see the same. The tree may be edited between
    ticks.

    Args:
        root: any behaviour of py_trees.
        visit: called with each node that `root.tick()` yields, which then ticks by itself; None for nobody.
        fixed_methods: a promise that no method of a node or of its class is replaced while the engine is in use, which
            spares looking for it.
    """

    def __init__(self, root: Behaviour, visit: Visit | None = None, *, fixed_methods: bool = False):
        self.root = root
        self._visit, self._fixed = visit, fixed_methods
        if visit is None:
            self._compile()

    def tick(self) -> None:
        """Do what `root.tick_once()` does.

        Raises:
            Exception: what a node raises, as it is; the tree is left as py_trees leaves it.
        """
        if self._visit is not None:
            for node in self.root.tick():
                self._visit(node)
            return
        if self._outdated():
            self._compile()
        self._tick(NOTHING)

    def halt(self) -> None:
        """Do what `root.stop(Status.INVALID)` does."""
        self.root.stop(INVALID)

    def _compile(self) -> None:
        self._compiler = compiler = _Compiler(self._fixed)
        whole = not deeper_than(_LEVELS, self.root)
        self._tick = (compiler.compile(self.root) if whole else compiler.left_alone(self.root, _TO_EXHAUSTION)).tick
        self._root_methods = Methods(() if self._fixed else [self.root])
        self._classes_changed = watch_classes(() if self._fixed else map(type, compiler.nodes))

    def _outdated(self) -> bool:
        if self._compiler.stale:
            return True
        if self._fixed:
            return False
        methods = self._root_methods
        return self._classes_changed() or ([*map(len, methods.dicts)] != methods.sizes and methods.replaced())


def make_ticker(node: Behaviour) -> Callable[[], object]:
    """Return what does `node.tick_once()`; nobody may replace methods of the nodes or edit them from now on."""
    if rules_of(node) is Rules.LEAF:
        return partial(_Compiler(fixed_methods=True).compile(node).tick, NOTHING)
    return TickEngine(node, fixed_methods=True).tick


class _Compiler:
    """From nodes to closures, bottom up, a few microseconds a node.

    Attributes:
        nodes: those compiled so far.
        stale: whether something was found that has changed since; that node was ticked by its own generator.
    """

    def __init__(self, fixed_methods: bool) -> None:
        self._fixed = fixed_methods
        self.nodes: list[Behaviour] = []
        self.stale = False

    def compile(self, node: object, verdict: Verdict = _TO_EXHAUSTION) -> Compiled:
        """Return the compiled node; what isn't known to the letter is ticked by its own generator."""
        rules = rules_of(node)
        if rules is Rules.OWN or not regular(node, rules):
            return self.left_alone(node, verdict)
        self.nodes.append(node)
        if rules is Rules.LEAF:
            return self._leaf(node)
        below = children_of(node, rules)
        kids = [self.compile(kid, _VERDICTS.get(rules, _TO_EXHAUSTION)) for kid in below]
        inner = [node, *(one for kid in kids for one in kid.inner)]
        nodes = [one for kid in kids for one in kid.nodes]
        changed_below = watch_all(inner, nodes, self._fixed)
        reset = make_reset(kids, changed_below)
        stop = make_stop(node, rules, kids, reset)
        look = Look(watch(node, below, self._fixed), changed_below, self._outdated(node, verdict))
        tick = self._tick(node, rules, look, kids, stop, reset)
        if isinstance(node, Conditional):
            tick = containers.conditional(node, look, tick)
        halt = make_halt(node, stop, look.changed)
        return Compiled(node, tick, halt, [node, *nodes], inner, silent(node, rules, kids))

    def _leaf(self, node: Any) -> Compiled:
        stop = make_stop(node, Rules.LEAF, (), lambda known: known)
        if not ours(node):
            halt = make_halt(node, stop, None)
            return Compiled(node, leaf(node), halt, [node], (), silent(node, Rules.LEAF, ()), only_updates(node))
        tick = our_leaf(node, stop)
        if isinstance(node, Conditional):
            tick = containers.conditional(node, None, tick)
        return Compiled(node, tick, make_halt(node, stop, None), [node])

    def _outdated(self, node: Behaviour, verdict: Verdict) -> Tick:
        own = by_generator(node, verdict)

        def outdated(known: int) -> Status:
            self.stale = True
            return own(known)

        return outdated

    def left_alone(self, node: Behaviour, verdict: Verdict) -> Compiled:
        """Return a node that is ticked and stopped by py_trees."""
        self.nodes.append(node)
        return Compiled(node, by_generator(node, verdict), lambda: node.stop(INVALID), [node])

    def _tick(self, node: object, rules: Rules, look: Look, kids: list[Compiled], stop: Stop, reset: Reset) -> Tick:
        if rules is Rules.KIND:
            return containers.automaton(node, look, kids)
        match rules:
            case Rules.SEQUENCE:
                return composites.sequence(node, look, kids, stop, reset)
            case Rules.SELECTOR:
                return composites.selector(node, look, kids, stop)
            case Rules.PARALLEL:
                return composites.parallel(node, look, kids, stop, reset)
        return composites.decorator(node, look, kids[0], stop)
