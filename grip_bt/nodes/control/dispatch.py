"""A state machine as a composite: one active child, and edges from its labelled end to the next one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from py_trees import composites
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from grip_bt.base.errors import LivelockError
from grip_bt.task.edges import Edges

from ..node import STATUS, Node
from .container import Container, Face

MAX_TRANSITIONS = 1000
"""Transitions in one tick that are taken for a loop without end."""


class _Steps(composites.Composite):
    """How the active child is ticked; where its end leads is `follow`."""

    status: Status
    current_child: Any
    initial: Node
    run_to_completion = False

    def tick(self) -> Iterator[Behaviour]:
        """Tick the active child; when it ends, go along its edge."""
        if self.status != Status.RUNNING:
            self.current_child = self.initial
            self.initialise()
        for _ in range(MAX_TRANSITIONS):
            child = self.current_child
            yield from child.tick()
            if child.status == Status.RUNNING:
                break
            successor = self.follow(child)
            if successor is None:
                yield self
                return
            self.current_child = successor
            if not self.run_to_completion:
                self.context.wake()
                break
        else:
            raise LivelockError(self.path, MAX_TRANSITIONS)
        self.status = Status.RUNNING
        yield self

    def follow(self, child: Node) -> Node | None:
        """Return the child that comes next, or end and return None."""
        raise NotImplementedError


class Dispatch(Container, _Steps):
    """A `state_machine`: at most one transition a tick, unless it runs to completion.

    Children aren't reset on entry beyond their own `initialise`; on leaving and interruption py_trees' rules hold.

    Args:
        face: what every container is made with; its `exits` stay empty.
        children: the states.
        initial: name of the first one.
        edges: (child, outcome, code) -> a child's name or one of the outcomes.
        run_to_completion: follow transitions within one tick, at most `MAX_TRANSITIONS`.
    """

    def __init__(
        self,
        face: Face,
        children: Iterable[Behaviour],
        initial: str,
        edges: Edges,
        run_to_completion: bool = False,
    ):
        composites.Composite.__init__(self, face.name, list(children))
        self.take(face)
        self.edges, self.run_to_completion = edges, run_to_completion
        self.by_name: dict[str, Node] = {child.name: child for child in self.children}
        self.initial = self.by_name[initial]

    def follow(self, child: Node) -> Node | None:
        """Go along the edge of the child's end; an edge to a sibling wins over an outcome of the same name."""
        target = self.edges.target(child.name, child.outcome or "", child.code)
        if target is None:
            raise LookupError(
                f"{self.path}: no edge leaves {child.name!r} by {child.outcome!r} (code {child.code!r});"
                f" add it under `on:` of {child.name!r}"
            )
        if target in self.by_name:
            return self.by_name[target]
        self.outcome = target
        self.stop(STATUS[self.meaning[target]])
        return None
