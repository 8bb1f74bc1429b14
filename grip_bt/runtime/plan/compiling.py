"""From a tree to closures, bottom up, a few microseconds a node."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from . import composites, controls, leaves
from .builtin import builtin
from .emit_ours import plain
from .hooks import entering, leaving
from .kinds import DECORATORS, Kind, conditional, kind_of, ours, overrides, plain_validation
from .parts import INVALID, F, Inside, Part, R, S, Verdict, Visit, foreign, halt_foreign
from .stopping import Stop, make_halt, make_stop
from .watch import Methods, watch_children

LEVELS = 150
"""Trees with more of them are left to py_trees, whose generators go deeper than functions that call functions."""

_ROOT, _TO_EXHAUSTION = Verdict(), Verdict()
_VERDICTS = {
    Kind.SEQUENCE: Verdict(leave=(F, R, INVALID), onward=S),
    Kind.SELECTOR: Verdict(leave=(R, S), onward=F),
}


class Compiler:
    """Compiles the nodes of one tree.

    Attributes:
        nodes: those compiled so far.
        stale: whether something was found that has changed since; the node in question was ticked by its own generator.

    Args:
        visit: called where py_trees yields a node; None for nobody.
        fixed_methods: somebody promises that no instance gets or loses a method of its life cycle.
        given: results that leaves of py_trees' own have given already, by `id` of the leaf.
    """

    def __init__(self, visit: Visit | None, fixed_methods: bool, given: dict[int, Status]):
        self.visit, self.fixed_methods, self._given = visit, fixed_methods, given
        self.nodes: list[Behaviour] = []
        self.stale = False

    def compile(self, node: Any, verdict: Verdict = _ROOT) -> Part:
        """Return the compiled node; what isn't known to the letter is ticked by its own generator."""
        kind = kind_of(node)
        if kind is not Kind.FOREIGN and not _regular(node, kind):
            kind = Kind.FOREIGN
        if verdict is _ROOT and deeper_than(LEVELS, node):
            kind = Kind.FOREIGN
        if kind is Kind.FOREIGN:
            part = Part(node, foreign(node, verdict, self.visit), halt_foreign(node))
        elif kind is Kind.LEAF:
            stop = make_stop(node, kind, (), _never)
            inside = None if ours(node) and not plain(node) else _inside(node, kind, (), stop, Methods())
            if ours(node):
                tick = leaves.our_leaf(node, stop, self.visit)
            else:
                known = builtin(node, self._given)
                tick = leaves.leaf(node, self.visit, known)
                inside = replace(inside, builtin=known) if inside is not None and known is not None else inside
            part = Part(node, self._conditional(node, tick), make_halt(stop), inside)
        else:
            part = self._inner(node, kind, verdict)
        self.nodes.append(node)
        return part

    def _inner(self, node: Any, kind: Kind, verdict: Verdict) -> Part:
        verdict_of_kids = _VERDICTS.get(kind, _TO_EXHAUSTION)
        kids = [self.compile(kid, verdict_of_kids) for kid in children_of(node, kind)]
        methods = Methods(() if self.fixed_methods else [kid.node for kid in kids])
        memory = node.memory if kind in _VERDICTS else None
        changed = watch_children(node, [kid.node for kid in kids], methods, memory)
        stop = make_stop(node, kind, kids, changed)

        def link(below: list[Part]) -> Callable[[], Status]:
            tick = self._tick(node, kind, below, stop)
            if ours(node):
                tick = self._conditional(node, _entered(entering(node), tick))
            return self._guarded(node, tick, changed, verdict)

        inside = _inside(node, kind, tuple(kids), stop, methods)
        relink = None if _writable(node, kind) and kids else link
        return Part(node, link(kids), make_halt(stop), inside, relink)

    def _tick(self, node: Any, kind: Kind, kids: list[Part], stop: Stop) -> Callable[[], Status]:
        ended = leaving(node, self.visit) if ours(node) else None
        match kind:
            case Kind.SEQUENCE:
                return composites.sequence(node, kids, stop, self.visit, ended)
            case Kind.SELECTOR:
                return composites.selector(node, kids, stop, self.visit, ended)
            case Kind.PARALLEL:
                return composites.parallel(node, kids, stop, self.visit)
            case Kind.DECORATOR:
                return controls.decorator(node, kids[0], stop, self.visit, ended)
            case Kind.GATE:
                inner = controls.decorator(node, kids[0], stop, self.visit, ended)
                return controls.gate(node, inner, stop, self.visit)
        assert ended is not None, "these kinds are ours"
        if kind is Kind.ROUNDS:
            return controls.rounds(node, kids, stop, self.visit, ended)
        if kind is Kind.TURNS:
            return controls.turns(node, kids, self.visit, ended)
        return controls.transitions(node, kids, self.visit, ended)

    def _conditional(self, node: Any, tick: Callable[[], Status]) -> Callable[[], Status]:
        return controls.conditional(node, tick, self.visit) if conditional(node) else tick

    def _guarded(
        self, node: Any, tick: Callable[[], Status], changed: Callable[[], bool], verdict: Verdict
    ) -> Callable[[], Status]:
        own = foreign(node, verdict, self.visit)

        def guarded() -> Status:
            if changed():
                self.stale = True
                return own()
            return tick()

        return guarded


def children_of(node: Any, kind: Kind) -> list[Behaviour]:
    """Return the children that the node ticks."""
    return [node.decorated] if kind in DECORATORS else list(node.children)


def deeper_than(levels: int, node: Behaviour) -> bool:
    """Tell whether a tree has more than so many levels."""
    row = [node]
    for _ in range(levels):
        row = [kid for parent in row for kid in (*parent.children, *_decorated(parent))]
        if not row:
            return False
    return True


def _decorated(node: Any) -> tuple[Behaviour, ...]:
    kid = getattr(node, "decorated", None)
    return () if kid is None or kid in node.children else (kid,)


def _regular(node: Any, kind: Kind) -> bool:
    """Tell whether the children can be compiled too: each is there once, and ours has ours alone."""
    if kind is Kind.LEAF:
        return True
    kids = children_of(node, kind)
    if len(set(map(id, kids))) != len(kids):
        return False
    return not ours(node) or all(ours(kid) and kind_of(kid) is not Kind.FOREIGN for kid in kids)


def _inside(node: Any, kind: Kind, kids: tuple[Part, ...], stop: Stop, methods: Methods) -> Inside | None:
    if kind is Kind.PARALLEL and not plain_validation(node):
        return None
    return Inside(
        kind,
        kids,
        stop,
        methods,
        overrides(node, "initialise"),
        overrides(node, "terminate"),
        getattr(node, "memory", None),
        getattr(node, "policy", None),
        ours(node),
        ours(node) and bool(getattr(node, "exits", None)) and node.exits_at_once,
    )


def _writable(node: Any, kind: Kind) -> bool:
    """Tell whether source is written for the tick of an inner node, and not only for those below it."""
    if not ours(node):
        return kind is not Kind.PARALLEL or plain_validation(node)
    return kind in (Kind.SEQUENCE, Kind.SELECTOR, Kind.DECORATOR) and plain(node)


def _entered(enter: Callable[[], None], tick: Callable[[], Status]) -> Callable[[], Status]:
    def entered() -> Status:
        enter()
        return tick()

    return entered


def _never() -> bool:
    return False
