"""When motions end: a part's motion begins when the one before has ended; what is told to stop is measured to rest."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, TypeVar

import numpy as np

from grip_bt.base.errors import GripError, NotStoppedError, listing
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Arm, Hand
from grip_bt.base.values import JointState

T = TypeVar("T")
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

    def begin(self, name: str, start: Callable[[], Operation[T]], waits: bool) -> Operation[T]:
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


def _matters(one: tuple[str, Operation[object]]) -> bool:
    _, work = one
    return not work.done() or work.busy or bool(work.given_up)


class Moved:
    """An arm or a hand, as leaves of a run get it."""

    def __init__(self, name: str, part: Arm | Hand, motions: Motions):
        self._name, self._part, self._motions = name, part, motions

    def stop(self) -> None:
        self._part.stop()
        self._motions.stop(self._name)

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._part, name)
        return partial(self._begin, found, name in _BEGIN) if name in _BEGIN or name in _GO_ON else found

    def _begin(
        self, method: Callable[..., Operation[Any]], waits: bool, *args: object, **named: object
    ) -> Operation[Any]:
        return self._motions.begin(self._name, partial(method, *args, **named), waits)


APART = 0.1
"""Two measurements this far apart tell whether joints stand still [s]."""
STILL = 2e-3
"""How far joints that stand still may be apart in them [rad or m]."""
MOVES = 0.05
"""Joints with a velocity above this move, where it is measured [rad/s or m/s]."""
LOOK = 0.005
"""How often what has been told to stop is looked at [s]."""

Measure = Callable[[Sequence[str]], Operation[JointState]]
"""Begins a measurement of joints that is taken from now on; ends with SensorError where none comes."""


@dataclass(frozen=True)
class Rest:
    """What was measured of the robot when a run had told everything to stop.

    Attributes:
        unconfirmed: part, or node whose work was told to stop -> why nobody can say that it has.
    """

    at_rest: tuple[str, ...] = ()
    unconfirmed: Mapping[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        said = [f"could not confirm that {name!r} stopped: {why}" for name, why in self.unconfirmed.items()]
        if self.at_rest:
            names = listing(map(repr, self.at_rest))
            said.append(f"{names} {'is' if len(self.at_rest) == 1 else 'are'} at rest")
        return "; ".join(said)


def measured_rest(parts: Sequence[Arm | Hand], measure: Measure | None, within: float) -> Rest:
    """Measure parts until they stand still, each in a thread of its own, `within` so many seconds in all.

    Where a part's last known state may be old, `measure` measures its joints anew.
    """
    deadline = time.monotonic() + within
    found: dict[str, str] = {}

    def look(part: Arm | Hand) -> None:
        found[part.name] = _look(part, measure, deadline)

    threads = [threading.Thread(target=look, args=(part,), name="grip_rest", daemon=True) for part in parts]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(max(0.0, deadline + 2 * APART - time.monotonic()))
    why = {part.name: found.get(part.name, f"nothing was measured for {within:g} s") for part in parts}
    return Rest(tuple(name for name in why if not why[name]), {name: said for name, said in why.items() if said})


def _look(part: Arm | Hand, measure: Measure | None, deadline: float) -> str:
    """Return why a part isn't known to stand still; nothing where it does."""
    try:
        before = part.state()
        while True:
            time.sleep(APART)
            if measure is None:
                now = part.state()
            else:
                measured = measure(before.names)
                measured.wait(max(APART, deadline - time.monotonic()))
                now = measured.result()
            moved = float(np.abs(now.ordered(before.names) - before.position).max(initial=0.0))
            moves = measure is not None and now.velocity is not None and np.abs(now.velocity).max(initial=0.0) > MOVES
            if moved <= STILL and not moves:
                return ""
            if time.monotonic() > deadline:
                return f"its joints still move, by {moved:.3f} within {APART:g} s"
            before = now
    except GripError as error:
        return str(error)
    except Exception as error:  # noqa: BLE001 - of somebody's driver; what it says is all that is known
        return f"{type(error).__name__}: {error}"


def ended(
    working: Callable[[], Sequence[Any]], within: float, hurry: Callable[[], bool] = lambda: False
) -> Sequence[Any]:
    """Wait, at most `within` [s] and not when somebody is in a hurry, until nothing works; return what still does."""
    deadline = time.monotonic() + within
    while (left := working()) and time.monotonic() < deadline and not hurry():
        time.sleep(LOOK)
    return left
