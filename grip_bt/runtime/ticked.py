"""A compiled task that somebody ticks by hand, in a program of theirs or a notebook."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from py_trees.trees import BehaviourTree

from grip_bt.base.values import Failure
from grip_bt.compilers import CompiledTree


class Tree(BehaviourTree):
    """A task as a tree of py_trees that is ready to tick: `tick`, `tick_tock`, or `root.tick_once()`.

    Visitors, handlers and displays of py_trees work on it. It has its robot until `shutdown`, or until the end of a
    `with` block. Nothing of it goes to a journal: `grip_bt.run` does that.
    """

    def __init__(self, compiled: CompiledTree, close: Callable[[], None]):
        super().__init__(compiled.root)
        self._compiled, self._close = compiled, close

    @property
    def outcome(self) -> str | None:
        return None if self._compiled.root.outcome is None else self._compiled.end().outcome

    @property
    def failure(self) -> Failure | None:
        return None if self.outcome is None else self._compiled.end().failure

    @property
    def data(self) -> dict[str, Any]:
        """The variables that have a value; those of a container by its path: `attempt/grasp`."""
        snapshot = self._compiled.data.snapshot().items()
        return {f"{path}/{name}" if path.strip("/") else name: value for (path, name), value in snapshot}

    def setup(self, *_: Any, **__: Any) -> None:
        """Do nothing: it was set up when it was made."""

    def shutdown(self) -> None:
        self.interrupt()
        self.root.stop()
        self._close()

    def __enter__(self) -> Tree:
        return self

    def __exit__(self, *_: object) -> None:
        self.shutdown()
