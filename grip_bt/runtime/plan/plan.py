"""A tree of py_trees, ticked without its generators, with nothing else to see."""

from __future__ import annotations

import threading
from collections.abc import Callable

from py_trees.behaviour import Behaviour

from .compiling import Compiler
from .parts import Part, R, Visit
from .regions import Regions, Tick
from .trace import Handed, Tracer
from .watch import Classes, Methods

LONGEST_WAIT = 64
"""Running ticks between two attempts to trace a tree that doesn't settle, at most."""

WARM_UP = 100
"""Ticks of an unchanged tree after which its source is generated."""


class Plan:
    """Ticks a tree as `root.tick_once()` does, only faster.

    Whoever looks at the tree after a tick sees what py_trees would have left: statuses, feedback messages, current
    children, tips; the nodes' callbacks are called in the same order and see the same. The tree may be edited between
    ticks.

    Args:
        root: any behaviour of py_trees.
        visit: called with each node at the moment when `root.tick()` would yield it; None for nobody.
        fixed_methods: a promise that no method of a node or of its class is replaced while the plan is in use, which
            spares looking for it.
    """

    def __init__(self, root: Behaviour, visit: Visit | None = None, *, fixed_methods: bool = False):
        self.root = root
        self._visit, self._fixed = visit, fixed_methods
        self._handed = Handed()
        self._clock = [0]
        self._trace: Callable[[], bool] | None = None
        self._traces = visit is None
        self._compile()

    def tick(self) -> None:
        """Do what `root.tick_once()` does.

        Raises:
            Exception: what a node raises, as it is; the tree is left as py_trees leaves it.
        """
        if self._trace is None:
            self._whole_tick()
        elif not self._trace():
            self._trace = None
            try:
                self._whole_tick()
            finally:
                self._handed.end()

    def _whole_tick(self) -> None:
        if self._outdated():
            self._compile()
        if self._warming:
            self._warm_up()
        self._clock[0] += 1
        self._run()
        if self._traces and self.root.status is R:
            self._settle()

    def halt(self) -> None:
        """Do what `root.stop(Status.INVALID)` does."""
        self._trace = None
        if self._outdated():
            self._compile()
        self._part.halt()

    def optimise(self) -> None:
        """Generate the source of the tree as it is now, instead of after some ticks in the background."""
        if self._outdated():
            self._compile()
        self._warming = 0
        if self._visit is None:
            self._run = self._generated(self._compiler, self._part, self._clock)

    def _compile(self) -> None:
        self._compiler = Compiler(self._visit, self._fixed, self._handed.given)
        self._part: Part = self._compiler.compile(self.root)
        nodes = () if self._fixed else self._compiler.nodes
        self._classes = Classes(type(node) for node in nodes)
        self._root_methods = Methods(() if self._fixed else [self.root])
        self._run = self._part.tick
        self._warming = WARM_UP if self._visit is None else 0
        self._ready: list[Tick] = []
        self._trace = None
        self._wait = self._patience = 2

    def _outdated(self) -> bool:
        if self._compiler.stale:
            return True
        if self._fixed:
            return False
        methods = self._root_methods
        return self._classes.changed() or ([*map(len, methods.dicts)] != methods.sizes and methods.replaced())

    def _warm_up(self) -> None:
        """Count down to generating source; then wait for it, without waiting."""
        if self._warming > 1:
            self._warming -= 1
            if self._warming == 1:
                compiler, part, clock, ready = self._compiler, self._part, self._clock, self._ready
                work = threading.Thread(
                    target=lambda: ready.append(self._generated(compiler, part, clock)), name="grip_plan", daemon=True
                )
                work.start()
        elif self._ready:
            self._run, self._warming = self._ready[0], 0

    def _settle(self) -> None:
        """Try to trace the next ticks, less and less often where the tree doesn't settle."""
        self._wait -= 1
        if self._wait or self._compiler.stale:
            self._wait = max(self._wait, 1)
            return
        self._trace = Tracer(self._part, self._handed, self._fixed).trace()
        self._patience = 2 if self._trace is not None else min(2 * self._patience, LONGEST_WAIT)
        self._wait = self._patience

    @staticmethod
    def _generated(compiler: Compiler, part: Part, clock: list[int]) -> Tick:
        def outdated() -> None:
            compiler.stale = True

        return Regions(outdated, clock).tick(part)
