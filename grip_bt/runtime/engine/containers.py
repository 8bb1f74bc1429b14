"""Ticks of compiled containers of ours: one for every kind, which is asked what follows what."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from py_trees.common import Status

from grip_bt.base.errors import NodeError
from grip_bt.nodes.node import STATUS
from grip_bt.task.exploration import UNKNOWN, Labels, NoWayError, Oracle
from grip_bt.task.kinds.base import CHILD, End, Ended, Kind, Run, Step
from grip_bt.task.parts import Edges

from .halting import Compiled, Tick, halt_all
from .known import F, R, S


def conditional(node: Any, inner: Tick) -> Tick:
    """`Conditional.tick`: look at the precondition before an activation begins."""

    def tick() -> Status:
        if node.status is R:
            return inner()
        try:
            holds = node.precondition.holds()
        except Exception as error:
            node.begin()
            node.stop(Status.INVALID)
            raise NodeError(node.path, error) from error
        if holds:
            return inner()
        node.begin()
        node._refuse()
        return F

    return tick


def automaton(node: Any, parts: Sequence[Compiled]) -> Tick:
    """The tick of a container: its kind is asked, or the rows that were made of its answers are followed."""
    rows = _rows(node, parts)
    return _asking(node, parts) if rows is None else _following(node, rows, parts)


Row = tuple[Any, Tick, Any, Any]
"""A child, its tick, and what follows its success and its failure: the position of another child, or an outcome."""


def _rows(node: Any, parts: Sequence[Compiled]) -> list[Row] | None:
    """Return what follows the ends of children; None for a kind that asks, counts, or looks at more than meanings.

    Its first child is the one in the first row.
    """
    kind, q = node.kind, Oracle(Labels({part.node.name: () for part in parts}, Edges(), Edges()))
    if kind.concurrent or kind.settles or kind.late_exits or type(kind).over is not Kind.over:
        return None

    def follows(step: Step) -> Any:
        if type(step) is Run and len(step.children) == 1 and step[1:] == (0, False) and not q.asked:
            return step.children[0]
        return step.outcome if type(step) is End and step.reason is CHILD and not q.asked else None

    try:
        starts = [kind.begin(None, q), *(kind.again(0, (i,), q) for i in range(len(parts)) if kind.reactive)]
        if not parts or any(follows(step) != 0 for step in starts):
            return None
        rows = []
        for i, part in enumerate(parts):
            after = [follows(kind.ended(0, i, Ended(UNKNOWN, UNKNOWN, said, UNKNOWN), q)) for said in STATUS]
            if None in after:
                return None
            rows.append((part.node, part.tick, *after))
    except (TypeError, NoWayError):
        return None
    return rows


def _following(node: Any, rows: Sequence[Row], parts: Sequence[Compiled]) -> Tick:
    """The tick of a container whose kind asks nothing: `KindNode.tick`, with the kind's answers known."""
    kind, reactive, selects = node.kind, node.kind.reactive, node.kind.shown == "selector"
    target = node.answers.exits.target if node.answers.exits else None
    composite, runs = kind.shown != "decorator", [(i,) for i in range(len(rows))]
    begin, end = _begin(node, parts), _end(node)

    def tick() -> Status:
        at = 0
        if node.status is not R:
            begin()
        elif not reactive and node.running:
            at = node.running[0]
            if selects and at:
                node.reset([row[0] for row in rows[:at]])
        while True:
            kid, advance, success, failure = rows[at]
            status = advance()
            if status is R:
                break
            following = success if status is S else failure
            if target is not None:
                following = target(kid.name, kid.outcome, kid.code) or following
            if following.__class__ is not int:
                return end(kid, following)
            at = following
        node.running, node.state, node.status = runs[at], 0, R
        if reactive:
            node.halt_others(runs[at])
            node.reset_after(kid)
        elif selects and kid is not node.current_child:
            node.reset_after(kid)
        if composite:
            node.current_child = kid
        return R

    return tick


def _begin(node: Any, parts: Sequence[Compiled]) -> Callable[[], None]:
    reset = parts if node.kind.resets else ()
    first = parts[0].node if node.kind.shown == "selector" else None

    def begin() -> None:
        node.last = node.state = node.outcome = node.failure = None
        node.asked = node.resting = False
        node.running, node.active = (), True
        node.observer.entered(node.path)
        if node.enter is not None:
            node.enter()
        halt_all(reset)
        if first is not None:
            node.current_child = first

    return begin


def _end(node: Any) -> Callable[[Any, str], Status]:
    kind, statuses = node.kind, {outcome: STATUS[meaning] for outcome, meaning in node.meaning.items()}
    reactive, composite, tidies = kind.reactive, kind.shown != "decorator", kind.shown == "selector" or kind.reactive

    def end(kid: Any, outcome: str) -> Status:
        node.last, node.why, node.outcome = kid, CHILD, outcome
        if reactive:
            node.halt_others(())
        if tidies:
            node.reset_after(kid)
        if node.leave is not None:
            node.leave()
        if composite:
            node.current_child = kid
        status = statuses[outcome]
        node.failure = kid.failure if status is F else None
        node.state, node.status = None, status
        node.report()
        return status

    return end


def _asking(node: Any, parts: Sequence[Compiled]) -> Tick:
    """The tick of any container: `KindNode.tick`, without its generators."""
    kids, ticks, kind = [part.node for part in parts], [part.tick for part in parts], node.kind
    reactive, patient, again = kind.reactive, kind.concurrent or not kind.settles, kind.again

    def tick() -> Status:
        before, step = node.running, None
        if node.status is not R or node.resting or not before:
            step, before = node.opening(), node.running
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
        node.land(step)
        return node.status

    return tick
