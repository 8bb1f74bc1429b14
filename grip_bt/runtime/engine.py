"""Ticks of a compiled task by closures: the calls that py_trees' generators make, in their order, only faster.

What has a `tick` or `stop` of its own, such as somebody's own behaviours, is ticked and stopped by that.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.errors import NodeError
from grip_bt.nodes.condition import Conditional
from grip_bt.nodes.container import KindNode
from grip_bt.nodes.leaf import Leaf
from grip_bt.nodes.node import Node
from grip_bt.task.kinds.base import Run

S, F, R, INVALID = Status.SUCCESS, Status.FAILURE, Status.RUNNING, Status.INVALID
_LEVELS = 150
"""What is deeper is left to py_trees, whose generators go deeper than functions that call functions."""
Tick = Callable[[], Status]
Stop = Callable[[Status], None]


@dataclass(frozen=True, slots=True)
class _Ticked:
    node: Any
    tick: Tick
    stop: Stop


def make_ticker(node: Behaviour) -> Tick:
    """Return what does `node.tick_once()`, and returns the status; nobody may edit the tree, or replace its methods.

    Whoever looks at the tree after a tick sees what py_trees would have left.
    """
    return _ticked(node, 0).tick


def _ticked(node: Any, level: int) -> _Ticked:
    if level > _LEVELS or not _is_known(node):
        return _Ticked(node, partial(_by_generator, node), node.stop)
    parts = [_ticked(child, level + 1) for child in node.children]
    stop = _make_stop(node, parts)
    tick = _automaton(node, parts, stop) if isinstance(node, KindNode) else _leaf(node, stop)
    return _Ticked(node, _conditional(node, tick) if isinstance(node, Conditional) else tick, stop)


def _is_known(node: Behaviour) -> bool:
    """Tell whether `tick` and `stop` are ours, of the class and of the instance, and those that it ticks are our nodes.

    Asking for `__dict__` would make CPython give up the instance's compact form.
    """
    ours = KindNode if isinstance(node, KindNode) else Leaf
    if not isinstance(node, ours):
        return False
    inner: Any = super(Conditional, node) if isinstance(node, Conditional) else node
    if _function(inner.tick) is not ours.tick or _function(node.stop) is not Node.stop:
        return False
    return all(isinstance(child, Node) for child in node.children) if ours is KindNode else not node.children


def _function(method: object) -> object:
    return getattr(method, "__func__", None)


def _by_generator(node: Behaviour) -> Status:
    for _ in node.tick():
        pass
    return node.status


def _halt_all(parts: Sequence[_Ticked]) -> None:
    for part in parts:
        if part.node.status is not INVALID:
            part.stop(INVALID)


def _make_stop(node: Any, parts: Sequence[_Ticked]) -> Stop:
    """Return what does `Node.stop`: settle the labelled end before, tell the observer after."""
    holds = isinstance(node, KindNode)

    def stop(status: Status) -> None:
        if status is S or status is F:
            node.conclude(status)
        else:
            node.outcome = node.failure = None
        try:
            if holds and status is INVALID:
                node.current_child = None
                _halt_all(parts)
            node.terminate(status)
            node.status = status
        finally:
            node.report()

    return stop


def _leaf(node: Any, stop: Stop) -> Tick:
    def tick() -> Status:
        try:
            if node.status is not R:
                node.inputs_read = {}
                node.begin()
                node.initialise()
            status: Status = node.update()
            if not isinstance(status, Status):
                status = INVALID
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


def _conditional(node: Any, inner: Tick) -> Tick:
    def tick() -> Status:
        if node.status is R:
            return inner()
        try:
            holds = node.precondition.holds()
        except Exception as error:
            node.begin()
            node.stop(INVALID)
            raise NodeError(node.path, error) from error
        if holds:
            return inner()
        node.begin()
        node._refuse()
        return F

    return tick


def _automaton(node: Any, parts: Sequence[_Ticked], stop: Stop) -> Tick:
    kids, ticks, kind = [part.node for part in parts], [part.tick for part in parts], node.kind
    reset = partial(_halt_all, parts)
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
