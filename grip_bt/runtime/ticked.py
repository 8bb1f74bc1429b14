"""A compiled task with its robot, in a program of somebody's or a notebook: a tree to tick, a machine to execute."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Self

from py_trees.trees import BehaviourTree

from grip_bt.base.values import Failure
from grip_bt.compilers import CompiledMachine, CompiledTree
from grip_bt.compilers.behaviour_state import Pacer, TaskEnd


class _Opened:
    """It has its robot until `shutdown`, or until the end of a `with` block; nothing of it goes to a journal."""

    _compiled: CompiledTree | CompiledMachine
    _close: Callable[[], None]

    def _end(self) -> TaskEnd | None:
        raise NotImplementedError

    @property
    def outcome(self) -> str | None:
        end = self._end()
        return None if end is None else end.outcome

    @property
    def failure(self) -> Failure | None:
        end = self._end()
        return None if end is None else end.failure

    @property
    def data(self) -> dict[str, Any]:
        """The variables that have a value; those of a container by its path: `attempt/grasp`."""
        snapshot = self._compiled.data.snapshot().items()
        return {f"{path}/{name}" if path.strip("/") else name: value for (path, name), value in snapshot}

    def shutdown(self) -> None:
        self._close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.shutdown()


class Tree(_Opened, BehaviourTree):
    """A task as a tree of py_trees that is ready to tick: `tick`, `tick_tock`, or `root.tick_once()`.

    Visitors, handlers and displays of py_trees work on it, and a notebook shows it with the status of each node. It has
    its robot until `shutdown`, or until the end of a `with` block. Nothing goes to a journal: `grip_bt.run` does that.
    """

    _compiled: CompiledTree

    def __init__(self, compiled: CompiledTree, close: Callable[[], None], drawn: Callable[[dict[str, str]], str]):
        super().__init__(compiled.root)
        self._compiled, self._close, self._drawn = compiled, close, drawn

    def _end(self) -> TaskEnd | None:
        return None if self._compiled.root.outcome is None else self._compiled.end()

    def _repr_svg_(self) -> str:
        return self._drawn({path: node.status.value.lower() for path, node in self._compiled.by_path.items()})

    def setup(self, *_: object, **__: object) -> None:
        """Do nothing: it was set up when it was made."""

    def shutdown(self) -> None:
        self.interrupt()
        self.root.stop()
        super().shutdown()


class Machine(_Opened):
    """A task as a state machine that is ready to be executed; `machine` is it, as of SMACH.

    It has its robot until `shutdown`, or until the end of a `with` block. Nothing of it goes to a journal.
    """

    _ended: TaskEnd | None = None

    def __init__(self, compiled: CompiledMachine, close: Callable[[], None], pacer: Pacer):
        self._compiled, self._close, self._pacer = compiled, close, pacer
        self.machine = compiled.machine

    def _end(self) -> TaskEnd | None:
        return self._ended

    def execute(self) -> str:
        """Execute it in this thread, and return the task's outcome.

        Raises:
            NodeError: a leaf raised; everything was interrupted.
        """
        self._ended = self._compiled.execute(self._pacer)
        return self._ended.outcome
