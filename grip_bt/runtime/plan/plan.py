"""A tree of py_trees, ticked without its generators, with nothing else to see."""

from __future__ import annotations

import threading

from py_trees.behaviour import Behaviour

from .compiling import Compiler
from .parts import Part, Visit
from .regions import Regions, Tick
from .watch import Classes, Methods

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
        self._compile()

    def tick(self) -> None:
        """Do what `root.tick_once()` does.

        Raises:
            Exception: what a node raises, as it is; the tree is left as py_trees leaves it.
        """
        if self._outdated():
            self._compile()
        if self._warming:
            self._warm_up()
        self._run()

    def halt(self) -> None:
        """Do what `root.stop(Status.INVALID)` does."""
        if self._outdated():
            self._compile()
        self._part.halt()

    def optimise(self) -> None:
        """Generate the source of the tree as it is now, instead of after some ticks in the background."""
        if self._outdated():
            self._compile()
        self._warming = 0
        if self._visit is None:
            self._run = self._generated(self._compiler, self._part)

    def _compile(self) -> None:
        self._compiler = Compiler(self._visit, self._fixed)
        self._part: Part = self._compiler.compile(self.root)
        nodes = () if self._fixed else list(self._compiler.parts)
        self._classes = Classes(type(node) for node in nodes)
        self._root_methods = Methods(() if self._fixed else [self.root])
        self._run = self._part.tick
        self._warming = WARM_UP if self._visit is None else 0
        self._ready: list[Tick] = []

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
                compiler, part, ready = self._compiler, self._part, self._ready
                work = threading.Thread(
                    target=lambda: ready.append(self._generated(compiler, part)), name="grip_plan", daemon=True
                )
                work.start()
        elif self._ready:
            self._run, self._warming = self._ready[0], 0

    @staticmethod
    def _generated(compiler: Compiler, part: Part) -> Tick:
        def outdated() -> None:
            compiler.stale = True

        return Regions(outdated).tick(part)
