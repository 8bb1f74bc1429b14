"""Whether what moved stands still: measured, not taken for granted because it was told to stop."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from grip_bt.base.errors import GripError, listing
from grip_bt.base.operation import Operation
from grip_bt.base.ports import Arm, Hand
from grip_bt.base.values import JointState

APART = 0.1
"""Two measurements so far apart tell whether joints stand still [s]."""
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
        at_rest: the parts that were measured to stand still.
        unconfirmed: part, or node whose work was told to stop -> why nobody can say that it has.
    """

    at_rest: tuple[str, ...] = ()
    unconfirmed: Mapping[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        """Return it as a part of a sentence; empty where there was nothing to look at."""
        said = [f"could not confirm that {name!r} stopped: {why}" for name, why in self.unconfirmed.items()]
        if self.at_rest:
            names = listing(map(repr, self.at_rest))
            said.append(f"{names} {'is' if len(self.at_rest) == 1 else 'are'} at rest")
        return "; ".join(said)


def measured_rest(parts: Sequence[Arm | Hand], measure: Measure | None, within: float) -> Rest:
    """Measure parts until they stand still, each in a thread of its own.

    Args:
        parts: arms and hands that were told to stop.
        measure: measures joints anew, where a part's last known state may be old.
        within: how long they may take in all [s].
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
            now = part.state() if measure is None else _waited(measure(before.names), deadline)
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


def _waited(operation: Operation[JointState], deadline: float) -> JointState:
    operation.wait(max(APART, deadline - time.monotonic()))
    return operation.result()


def ended(
    working: Callable[[], Sequence[Any]], within: float, hurry: Callable[[], bool] = lambda: False
) -> Sequence[Any]:
    """Wait, at most `within` [s] and not when somebody is in a hurry, until nothing works; return what still does."""
    deadline = time.monotonic() + within
    while (left := working()) and time.monotonic() < deadline and not hurry():
        time.sleep(LOOK)
    return left
