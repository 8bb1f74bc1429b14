"""A fake component: replies from a list."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import cycle
from typing import Any

from grip_bt.errors import ExpectedError, ServerLostError
from grip_bt.operation import Operation

from .schedule import AtOnce, Schedule

Reply = Mapping[str, Any] | ExpectedError | Callable[[Mapping[str, Any]], Mapping[str, Any]]


class FakeComponent:
    """Implements `ports.Component`.

    Args:
        replies: one after the other, again and again: fields of the response, a function of the request that returns
            them, or an error.
        schedule: its time; at once when None.
        delay: time to an answer [s].
    """

    def __init__(self, replies: Iterable[Reply] = (), schedule: Schedule | None = None, delay: float = 0.0):
        self._replies = cycle(tuple(replies))
        self._schedule, self._delay = schedule or AtOnce(), delay
        self.requests: list[Mapping[str, Any]] = []

    def call(self, request: Mapping[str, Any]) -> Operation[Mapping[str, Any]]:
        """Answer with the next reply; ServerLostError where there is none."""
        self.requests.append(dict(request))
        reply = next(self._replies, ServerLostError("the fake component has no replies"))
        operation: Operation[Mapping[str, Any]] = Operation()

        def answer() -> None:
            if isinstance(reply, ExpectedError):
                operation.fail(reply)
            else:
                operation.succeed(reply(request) if callable(reply) else reply)

        self._schedule.after(self._delay, answer)
        return operation
