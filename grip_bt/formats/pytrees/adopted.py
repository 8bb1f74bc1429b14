"""Somebody's own tree of py_trees under the runner: it ticks as it is, and what it does is reported."""

from __future__ import annotations

import copy
import logging
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard
from py_trees.common import Status

from grip_bt.base.errors import NodeError
from grip_bt.base.values import Failure
from grip_bt.compilers import CompiledTree, Pacer, TaskEnd, drive
from grip_bt.compilers.resolve import resolve
from grip_bt.compilers.scopes import UNSET, Scopes
from grip_bt.nodes.node import LABEL, SILENT, Observer
from grip_bt.nodes.tree_code import FoundTree
from grip_bt.task import Task
from grip_bt.task.catalog import Catalog

from .keys import Keys
from .tree import drawn, is_equal

_log = logging.getLogger(__name__)


class AdoptedTree(CompiledTree):
    """A tree that nobody compiled, as the runner has it.

    Args:
        found: the tree.
        source: where it comes from.
        ticks: how often it is ticked, whether its root ends or not; None: until its root has ended.
        setup: what its behaviours are set up with, such as `node`.
        alone: entered for each tick; it keeps callbacks of other threads out.
    """

    def __init__(
        self,
        found: FoundTree,
        source: str,
        ticks: int | None = None,
        setup: dict[str, Any] | None = None,
        alone: AbstractContextManager[object] | None = None,
    ):
        self.task, places, keys = drawn(found.tree.root, source)
        self._resolved = resolve(self.task, Catalog.builtin())
        self.data, self.root, self.by_path, self.leaves = self._resolved.scopes, found.tree.root, {}, {}
        self._found, self._ticks, self._setup, self._alone = found, ticks, setup or {}, alone or nullcontext()
        self._board = _Board(self.data, self.task, keys)
        self._watched = [_Watched(behaviour, path, self._board) for path, behaviour in places.items()]

    @property
    def rate(self) -> float | None:
        """How often its code would tick it [Hz]; None where that isn't known."""
        return 1 / self._found.period if self._found.period else None

    def ticker(self) -> Callable[[], object]:
        """Return the tick of the tree itself, with all that belongs to it."""
        return self._tick

    def observe(self, observer: Observer) -> None:
        """Have every activation, and every change of the blackboard, reported to `observer`."""
        self.data.on_write = observer.wrote
        self._board.observer = observer
        for each in self._watched:
            each.observer = observer

    def prepare(self, context: Any) -> None:
        """Set the tree up, unless its own code has. Raises NodeError: one of its behaviours can't be set up."""
        if self._found.ready:
            return
        try:
            self._found.tree.setup(**self._setup)
        except Exception as error:
            raise NodeError("/", error) from error

    def release(self) -> None:
        """Shut the tree down, and have it as it was."""
        for each in self._watched:
            each.leave()
        try:
            self._found.tree.shutdown()
        except Exception:  # noqa: BLE001 - the run has ended, with a result that this must not replace
            _log.exception("shutdown of the tree")

    def execute(self, pacer: Pacer, tick: Callable[[], object] | None = None) -> TaskEnd:
        """Tick until the root has ended, or as often as was said; `tick` does one, the tree's own by default."""
        tick, left = tick or self._tick, self._ticks
        self.data[Scopes.TASK].reset()
        self._board.look("/", thoroughly=True)
        try:
            if left is None:
                drive(self.root, pacer, tick)
                return self.end()
            for _ in range(left):
                seen = pacer.turn()
                tick()
                pacer.rest(seen)
            return self.end()
        finally:
            if self.root.status not in LABEL:
                self.root.stop(Status.INVALID)
            for each in self._watched:
                each.interrupt()

    def end(self) -> TaskEnd:
        """Return how the tree has ended; one that still runs after its ticks has done what was asked."""
        label = LABEL.get(self.root.status, "success")
        reason = Failure("foreign", str(self.root.feedback_message)) if label == "failure" else None
        return TaskEnd(label, label, reason)

    def _tick(self) -> None:
        with self._alone:
            self._found.tree.tick()
            self._board.look("/", thoroughly=True)


class _Watched:
    """One behaviour, whose `tick` and `stop` report and do what they did."""

    def __init__(self, behaviour: Behaviour, path: str, board: _Board):
        self.behaviour, self.path, self._board = behaviour, path, board
        self.observer: Observer = SILENT
        self._active, self._said = False, ""
        self._tick, self._stop = behaviour.tick, behaviour.stop
        node: Any = behaviour
        node.tick, node.stop = self.tick, self.stop

    def tick(self) -> Iterator[Behaviour]:
        """Tick; the end is told before whoever ticks it sees it."""
        if not self._active:
            self._active, self._said = True, ""
            self.observer.entered(self.path)
        try:
            for node in self._tick():
                if node is self.behaviour:
                    self._settle()
                yield node
        except NodeError:
            raise
        except Exception as error:
            raise NodeError(self.path, error) from error

    def _settle(self) -> None:
        status, message = self.behaviour.status, str(self.behaviour.feedback_message)
        self._board.look(self.path)
        if status in LABEL:
            self._active = False
            reason = Failure("foreign", message) if status is Status.FAILURE else None
            self.observer.ended(self.path, LABEL[status], reason)
        elif message and message != self._said:
            self._said = message
            self.observer.message(self.path, message)

    def stop(self, new_status: Status = Status.INVALID) -> None:
        self._stop(new_status)
        if new_status is Status.INVALID:
            self.interrupt()

    def interrupt(self) -> None:
        if self._active:
            self._active = False
            self.observer.interrupted(self.path)

    def leave(self) -> None:
        for name in ("tick", "stop"):
            vars(self.behaviour).pop(name, None)


class _Board:
    """Watches py_trees' blackboard, and writes the variables that stand for its keys."""

    def __init__(self, data: Scopes, task: Task, keys: Keys):
        self.observer: Observer = SILENT
        self._data, self._task, self._keys = data, task, keys
        self._seen: dict[str, tuple[Any, Any]] = {}

    def look(self, path: str, thoroughly: bool = False) -> None:
        """Write what has changed; `path` has changed it. `thoroughly`: values that were changed in place too."""
        there = Blackboard.storage
        for key, value in there.items():
            old, inside = self._seen.get(key, (UNSET, None))
            if value is not old or (thoroughly and not is_equal(inside, _inside(value), otherwise=True)):
                self._seen[key] = value, _inside(value)
                self._write(path, key, value)
        if len(self._seen) > len(there):
            for key in self._seen.keys() - there.keys():
                del self._seen[key]
                self._write(path, key, None)

    def _write(self, path: str, key: str, value: Any) -> None:
        name = self._keys.variable(key)
        if name in self._task.variables:
            self._data.writer(path, key, self._data[Scopes.TASK].cell(name))(value)
        else:
            self.observer.wrote(path, name, "Any", value)


def _inside(value: Any) -> Any:
    """Return what shows that a value was changed in place."""
    if isinstance(value, list | dict | set):
        return copy.copy(value)
    return dict(vars(value)) if hasattr(value, "__dict__") and not isinstance(value, type) else None
