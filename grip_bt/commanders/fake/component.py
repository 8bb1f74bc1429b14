"""A fake component: replies from a list."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import cycle
from typing import Any

from grip_bt.base.failures import ExpectedError, ServerLostError
from grip_bt.base.operation import Operation

from .schedule import AtOnce, Schedule

Reply = Mapping[str, Any] | ExpectedError | Callable[[Mapping[str, Any]], Mapping[str, Any]]


class FakeComponent:
    """Implements `ports.Component`.

    Args:
        replies: one after the other, again and again: fields of the response, a function of the request that returns
            them, or an error.
        schedule: its time; at once when None.
        delay: time to an answer [s].

    Attributes:
        requests: what it was asked.
        given: how many replies it has given.
    """

    def __init__(self, replies: Iterable[Reply] = (), schedule: Schedule | None = None, delay: float = 0.0):
        self._replies = cycle(tuple(replies))
        self._schedule, self._delay = schedule or AtOnce(), delay
        self.requests: list[Mapping[str, Any]] = []
        self.given = 0

    def put_back(self, given: int) -> None:
        """Go on with the reply that comes after so many.

        Args:
            given: how many it had given.
        """
        for _ in range(given - self.given):
            next(self._replies, None)
        self.given = max(given, self.given)

    def call(self, request: Mapping[str, Any]) -> Operation[Mapping[str, Any]]:
        """Answer with the next reply; ServerLostError where there is none."""
        self.requests.append(dict(request))
        self.given += 1
        reply = next(self._replies, ServerLostError("the fake component has no replies"))
        operation: Operation[Mapping[str, Any]] = Operation()

        def answer() -> None:
            if isinstance(reply, ExpectedError):
                operation.fail(reply)
            else:
                operation.succeed(reply(request) if callable(reply) else reply)

        self._schedule.after(self._delay, answer)
        return operation
