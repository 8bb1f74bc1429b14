"""The words of a demonstration: a line an attempt, and a table an object at the end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .attempts import Attempt


def attempt_line(attempt: Attempt) -> str:
    """Return one attempt in a line."""
    what = attempt.target or ("nothing left" if attempt.outcome == "nothing_left" else "no object")
    if attempt.outcome is None:
        how = "stopped"
    elif attempt.failure is not None:
        how = f"failed at {attempt.where or 'the task'}: {attempt.failure}"
    elif attempt.outcome == "success":
        how = (
            "held, and put into the crate" if attempt.held else "put into the crate, says the task; the hand was empty"
        )
    else:
        how = attempt.outcome.replace("_", " ")
    return f"attempt {attempt.number:<2} {attempt.duration:6.1f} s  {what:<12} {how}"


def object_table(truth: Mapping[str, Any], attempts: Sequence[Attempt]) -> list[str]:
    """Return a line per object: attempts, why they failed, and what the referee says."""
    rows = [("object", "attempts", "held", "placed", "time [s]", "why attempts failed")]
    for name, state in truth.items():
        mine = [a for a in attempts if a.target == name]
        why = "; ".join(f"{a.where}: {a.failure.code}" for a in mine if a.failure is not None) or "-"
        held = "yes" if any(name in a.held for a in mine) else "no"
        placed = "yes" if state.status == "placed" else f"no ({state.status})"
        rows.append((name, str(len(mine)), held, placed, f"{sum(a.duration for a in mine):.1f}", why))
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]) - 1)]
    return ["  ".join([*(c.ljust(w) for c, w in zip(row[:-1], widths, strict=True)), row[-1]]) for row in rows]
