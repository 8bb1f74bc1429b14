"""How a run has ended."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from grip_bt.base.values import Failure
from grip_bt.compilers import CompiledMachine, CompiledTree
from grip_bt.compilers.binding import parts_of
from grip_bt.runtime.motion_end import Rest
from grip_bt.runtime.stopping import Zombie

RunStatus = Literal["success", "failure", "error", "stopped", "died"]


@dataclass(frozen=True)
class RunResult:
    """How a run has ended.

    Attributes:
        outcome: the task's outcome; None after a stop or an error.
        meaning: `success` or `failure`; None after a stop or an error.
        status: the meaning, or `error`, or `stopped`; `died` where whoever controlled it had gone.
        duration: on the run's clock [s].
        error: what a leaf raised, in a NodeError that names it; the journal has the traceback.
        zombies: leaves whose code hadn't returned at the end; it was left behind.
        rest: what was measured of the robot after a stop or an error.
        data: the task's variables that have a value, with their last ones.
    """

    outcome: str | None
    meaning: str | None
    status: RunStatus
    failure: Failure | None
    ticks: int
    duration: float
    error: BaseException | None = None
    zombies: tuple[Zombie, ...] = ()
    rest: Rest = Rest()
    data: Mapping[str, object] = field(default_factory=dict, compare=False, repr=False)


def own_labels(compiled: CompiledTree | CompiledMachine) -> dict[str, Any]:
    """Return what outcomes mean that don't say so themselves: whoever reads the journal has no other way to know."""
    found = {
        path: own
        for path, part in parts_of(compiled).items()
        if (own := {name: meaning for name, meaning in part.meaning.items() if name != meaning})
    }
    return {"outcomes": found} if found else {}
