"""A tree of py_trees, ticked without its generators, with nothing else to see."""

from __future__ import annotations

from py_trees.behaviour import Behaviour

from .compiling import Compiler
from .parts import Part, Visit
from .watch import Classes, Methods


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
        self._part.tick()

    def halt(self) -> None:
        """Do what `root.stop(Status.INVALID)` does."""
        if self._outdated():
            self._compile()
        self._part.halt()

    def _compile(self) -> None:
        self._compiler = Compiler(self._visit, self._fixed)
        self._part: Part = self._compiler.compile(self.root)
        nodes = () if self._fixed else list(self._compiler.parts)
        self._classes = Classes(type(node) for node in nodes)
        self._root_methods = Methods(() if self._fixed else [self.root])

    def _outdated(self) -> bool:
        if self._compiler.stale:
            return True
        if self._fixed:
            return False
        methods = self._root_methods
        return self._classes.changed() or ([*map(len, methods.dicts)] != methods.sizes and methods.replaced())
