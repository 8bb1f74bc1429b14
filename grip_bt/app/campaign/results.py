"""Results of a campaign: a line of JSON a trial, on disk as soon as it has ended."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypedDict

from grip_bt.base.errors import CampaignError, NotWritableError

_FORMAT = 1
Plain = bool | int | float | str | None


class TrialRow(TypedDict, total=False):
    """A trial, and what came of it; `_trial` and `judged` say what each is."""

    variant: str
    seed: int
    status: str
    outcome: str | None
    code: str | None
    message: str
    duration: float | None
    wall: float
    run: str | None
    truth: Mapping[str, str] | None
    contradicted: bool
    unconfirmed: str
    counts: dict[str, int]
    measures: dict[str, Plain]
    success: bool
    unclear: dict[str, str]


@dataclass
class Results:
    """What is in a file of results.

    Attributes:
        path: the file.
        head: about the campaign: `name`, `doc`, `measures`, `variants` (name -> its settings).
        rows: the trials, in the order of their ends: `variant`, `seed`, and what `judged` returns.
    """

    path: Path
    head: Mapping[str, Any]
    rows: list[TrialRow] = field(default_factory=list)

    @property
    def done(self) -> set[tuple[str, int]]:
        """The trials that are there."""
        return {(row["variant"], row["seed"]) for row in self.rows}

    def add(self, row: TrialRow) -> None:
        """Write a trial; it is on disk when this returns.

        Raises:
            NotWritableError: it can't be written.
        """
        _append(self.path, row)
        self.rows.append(row)


def begin(path: Path, head: Mapping[str, Any], resume: bool) -> Results:
    """Open a file of results for more trials.

    Args:
        path: the file.
        head: of the campaign as it is now.
        resume: whether trials that are there are kept and not run again.

    Raises:
        CampaignError: it is there, and `resume` isn't asked; or it was made with other settings, which are named.
        NotWritableError: it can't be written.
    """
    if not path.exists():
        _append(path, {"campaign": _FORMAT, **head})
        return Results(path, head)
    if not resume:
        advice = "continue them with --resume, remove the file, or choose another one with -o"
        raise CampaignError(str(path), f"there are results already: {advice}")
    results = read(path)
    for variant, now in head["variants"].items():
        before = results.head["variants"].get(variant)
        changed = [] if before in (None, now) else [key for key in now if now[key] != before.get(key)]
        if changed:
            text = f"{variant!r} isn't what it was when these trials ran (changed: {', '.join(changed)})"
            raise CampaignError(
                str(path), f"{text}; results of different settings aren't mixed: start a new file with -o FILE"
            )
    _end_torn_line(path)
    return results


def read(path: Path) -> Results:
    """Read results; a last line that was cut off while it was written is left out.

    Raises:
        CampaignError: it isn't such a file.
    """
    try:
        lines = path.read_text().split("\n")
        rows = [json.loads(line) for line in lines[:-1] if line]
    except OSError as error:
        raise CampaignError(
            str(path), f"can't be read: {error.strerror}; `grip bench CAMPAIGN` writes results"
        ) from error
    except ValueError as error:
        raise CampaignError(str(path), f"can't be read as results of a campaign: {error}") from error
    if not rows or not isinstance(rows[0], dict) or rows[0].get("campaign") != _FORMAT:
        raise CampaignError(str(path), "these aren't results of a campaign: `grip bench CAMPAIGN` writes them")
    return Results(path, rows[0], rows[1:])


def _append(path: Path, row: Mapping[str, object] | TrialRow) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("a") as file:
            file.write(json.dumps(row, default=str) + "\n")
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        raise NotWritableError(path, error, "give another file with -o") from error


def _end_torn_line(path: Path) -> None:
    """Remove what a crash has left of a line."""
    text = path.read_bytes()
    if not text.endswith(b"\n"):
        path.write_bytes(text[: text.rfind(b"\n") + 1])
