"""What a run answers to the kind of one of its containers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from grip_bt.base.errors import NodeError
from grip_bt.base.evaluation import same_literal
from grip_bt.base.ports import Context
from grip_bt.base.types import Value
from grip_bt.task.kinds.base import Ended, State
from grip_bt.task.parts import Case, Edges

T = TypeVar("T")


class Answers:
    """The `Questions` of a kind, where they are described, answered from a run's variables and clock [s].

    Attributes:
        ends: how the children have ended, of a kind that is concurrent.
        kept: what the kind keeps from one activation to the next.
        judge: tells whether a time has come, in place of the clock.
    """

    context: Context

    def __init__(self, path: str, names: Sequence[str], exits: Edges, edges: Edges):
        self.path, self.names, self.exits, self.edges = path, names, exits, edges
        self.conditions: dict[str, Callable[[], bool]] = {}
        self.readers: dict[str, Callable[[], Value]] = {}
        self.writers: dict[str, Callable[[Value], None]] = {}
        self.ends: Sequence[Ended | None] = ()
        self.kept: State = None
        self.judge: Callable[[float], bool] | None = None

    def at(self, name: str) -> int:
        return self.names.index(name)

    def now(self) -> float:
        return self.context.clock.now()

    def deadline(self, seconds: float) -> float:
        at = self.now() + seconds
        self.context.wake_at(at)
        return at

    def passed(self, at: float) -> bool:
        return self.now() >= at if self.judge is None else self.judge(at)

    def up(self, count: int) -> int:
        return count + 1

    def reached(self, count: int, limit: int) -> bool:
        return count >= limit

    def pick(self, count: int, size: int) -> int:
        return count % size

    def holds(self, key: str) -> bool:
        return self._named(self.conditions[key])

    def value(self, key: str) -> Value:
        return self._named(self.readers[key])

    def match(self, key: str, literals: Sequence[tuple[str, Case]], default: str) -> str:
        value = self.value(key)
        return next((child for child, literal in literals if same_literal(value, literal)), default)

    def items(self, key: str) -> tuple[Value, ...]:
        items = self.value(key)
        if not isinstance(items, list | tuple):
            error = TypeError(f"`{key}` is {items!r}, a {type(items).__name__}, not a list")
            raise NodeError(self.path, error) from error
        return tuple(items)

    def empty(self, left: tuple[Value, ...]) -> bool:
        return not left

    def take(self, left: tuple[Value, ...]) -> tuple[Value, tuple[Value, ...]]:
        return left[0], left[1:]

    def put(self, key: str, value: Value) -> None:
        self._named(lambda: self.writers[key](value))

    def exit(self, end: Ended) -> str | None:
        return self.exits.target(end.child, end.outcome, end.code)

    def edge(self, end: Ended) -> str:
        target = self.edges.target(end.child, end.outcome, end.code)
        if target is None:
            raise LookupError(
                f"{self.path}: no edge leaves {end.child!r} by {end.outcome!r} (code {end.code!r});"
                f" add it under `on:` of {end.child!r}"
            )
        return target

    def written(self) -> None:
        """Do nothing when a variable of a condition is written: in a machine nobody looks while a child runs."""

    def ask(self, text: str) -> None:
        """Do nothing: in a machine nothing runs beside what decides."""

    def _named(self, compute: Callable[[], T]) -> T:
        """Return what is computed; errors name the container."""
        try:
            return compute()
        except NodeError:
            raise
        except Exception as error:
            raise NodeError(self.path, error) from error
