"""Motions of a run's arms and hands, whoever has begun them: each ends before the next one begins."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from grip_bt.base.errors import NotStoppedError
from grip_bt.base.operation import Operation

_BEGIN = ("execute", "jog", "open", "close", "move")
"""Methods of `ports.Arm` and `ports.Hand` that begin a motion."""
_GO_ON = ("steer", "steer_to")
"""Those that begin one, or go on with the one under way."""


class Motions:
    """What leaves were told to stop, and motions that were begun through the parts of a run; until they have ended."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._of_leaves: list[tuple[str, Operation[Any]]] = []
        self._of_parts: list[tuple[str, Operation[Any]]] = []

    def left(self, path: str, work: Operation[Any]) -> None:
        """Take note of a leaf's work that was told to stop."""
        with self._lock:
            self._of_leaves = [*(one for one in self._of_leaves if _matters(one)), (path, work)]

    def unfinished(self) -> Sequence[str]:
        """Return the paths of the leaves whose work was told to stop and hasn't ended; else the names of such parts.

        Raises:
            NotStoppedError: of one of them nobody can say whether it has.
        """
        with self._lock:
            known = (self._of_leaves, self._of_parts)
        for name, work in (*known[0], *known[1]):
            if work.given_up:
                raise NotStoppedError([name], work.given_up)
        leaves, parts = (list(dict.fromkeys(name for name, work in some if work.lingers)) for some in known)
        return leaves or parts

    def begin(self, name: str, start: Callable[[], Operation[Any]], waits: bool) -> Operation[Any]:
        """Begin a motion of a part; with `waits` when all that was told to stop has ended.

        Raises:
            NotStoppedError: of something nobody can say whether it has.
        """
        if waits and self.unfinished() and (ended := self._all_ended()) is not None:
            return ended.then(lambda _: self.begin(name, start, waits))
        motion = start()
        with self._lock:
            kept = [one for one in self._of_parts if one[1] is not motion and _matters(one)]
            self._of_parts = [*kept, (name, motion)]
        return motion

    def stop(self, name: str) -> None:
        """Take note that a part was told to hold."""
        for part, motion in list(self._of_parts):
            if part == name:
                motion.cancel()

    def _all_ended(self) -> Operation[None] | None:
        """Return what ends when all has that is stopping now; None where only code works on that can't be stopped."""
        with self._lock:
            all_known = [work for _, work in (*self._of_leaves, *self._of_parts)]
        waited = [work for work in all_known if work.cancel_asked and not work.done()]
        if not waited:
            return None
        all_ended: Operation[None] = Operation()

        def look() -> None:
            if all(work.done() for work in waited):
                all_ended.succeed(None)

        for work in waited:
            work.add_done_callback(look)
        return all_ended


def _matters(one: tuple[str, Operation[Any]]) -> bool:
    _, work = one
    return not work.done() or work.busy or bool(work.given_up)


class Moved:
    """An arm or a hand, as leaves of a run get it.

    Args:
        name: its name in the project.
        part: implements `ports.Arm` or `ports.Hand`.
        motions: of the run.
    """

    def __init__(self, name: str, part: Any, motions: Motions):
        self._name, self._part, self._motions = name, part, motions

    def stop(self) -> None:
        """Hold where it is now and end a motion under way."""
        self._part.stop()
        self._motions.stop(self._name)

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._part, name)
        return partial(self._begin, found, name in _BEGIN) if name in _BEGIN or name in _GO_ON else found

    def _begin(self, method: Callable[..., Operation[Any]], waits: bool, *args: Any, **named: Any) -> Operation[Any]:
        return self._motions.begin(self._name, partial(method, *args, **named), waits)
