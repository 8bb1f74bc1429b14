"""How a run has ended."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import Literal

from grip_bt.base.values import Failure
from grip_bt.compilers import CompiledMachine, CompiledTree
from grip_bt.compilers.binding import parts_of
from grip_bt.runtime.journal_events import Event
from grip_bt.runtime.journal_reader import JournalReader
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
        run, journal: its id, and the journal that it is in; empty where it went to none.
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
    run: str = field(default="", compare=False)
    journal: Path | None = field(default=None, compare=False, repr=False)

    def events(self) -> list[Event]:
        """Return what happened, from the journal, in order. Raises JournalError where that is gone."""
        if self.journal is None:
            return []
        with JournalReader(self.journal) as reader:
            return reader.events(self.run)

    def _repr_html_(self) -> str:
        """Return the end, the variables, and the first hundred ends of nodes, as tables."""
        end = {"status": self.status, "outcome": self.outcome, "failure": self.failure, "duration [s]": self.duration}
        ends = [(f"{each.t:.3f}", each.path, each.outcome, each.code) for each in self.events() if each.event == "exit"]
        rows = [*end.items(), *self.data.items()]
        return _html(rows, "result", "") + _html(ends[:100], "t [s]", "node", "outcome", "reason")


def _html(rows: Iterable[Sequence[object]], *head: str) -> str:
    cells = [f"<td>{'</td><td>'.join(escape('' if v is None else str(v)) for v in row)}</td>" for row in rows]
    lines = [f"<th>{'</th><th>'.join(head)}</th>", *cells]
    return f"<table><tr>{'</tr><tr>'.join(lines)}</tr></table>"


def own_labels(compiled: CompiledTree | CompiledMachine) -> dict[str, object]:
    """Return what outcomes mean that don't say so themselves: whoever reads the journal has no other way to know."""
    found = {
        path: own
        for path, part in parts_of(compiled).items()
        if (own := {name: meaning for name, meaning in part.meaning.items() if name != meaning})
    }
    return {"outcomes": found} if found else {}
