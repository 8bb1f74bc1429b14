"""What differs between two runs of one journal or of two, event by event and bit by bit.

Compared are the events in order with paths, kinds, outcomes, codes, data and times on the run's clock, every value
written, and every kept state. Left out are facts about the process (`run_started`), and our time in `Plan`s.
"""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from grip_bt.runtime import JournalReader

MEASURED = {"planning_time"}
"""Fields of values that hold our time and not the run's."""


@dataclass(frozen=True)
class Said:
    """An event, without what is allowed to differ."""

    t: float
    path: str
    event: str
    outcome: str | None
    code: str | None
    data: str


@dataclass(frozen=True)
class Sameness:
    """What a comparison has found: numbers of events, of kept states and written values, and the pairs that differ."""

    events: tuple[int, int]
    kept: int
    written: int
    differences: tuple[tuple[Said | None, Said | None], ...]


def compared(one: tuple[Path, str], two: tuple[Path, str]) -> Sameness:
    """Compare two runs, each given by its journal and its id."""
    first, second = list(said(*one)), list(said(*two))
    length = max(len(first), len(second))
    pairs = zip(first + [None] * (length - len(first)), second + [None] * (length - len(second)), strict=True)
    return Sameness(
        (len(first), len(second)),
        sum(event.event == "kept" for event in first),
        sum(event.event == "write" for event in first),
        tuple((a, b) for a, b in pairs if a != b),
    )


def said(journal: Path, run: str) -> Iterator[Said]:
    """Yield what the events of a run say."""
    with JournalReader(journal) as reader:
        for event in reader.iterate(run):
            data: Any = dict(event.data or {})
            if event.event in ("run_started", "state"):
                data = ""
            elif "hash" in data:
                named = {key: data[key] for key in ("variable", "part", "type") if key in data}
                data = f"{named} {hashlib.sha256(as_bytes(reader.value(event))).hexdigest()}"
            yield Said(event.t, event.path, event.event, event.outcome, event.code, repr(data))


def as_bytes(value: Any) -> bytes:
    """Return bytes that are the same for the same value only."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype}{value.shape}".encode() + np.ascontiguousarray(value).tobytes()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        names = [field.name for field in dataclasses.fields(value) if field.name not in MEASURED]
        return type(value).__name__.encode() + b"".join(n.encode() + as_bytes(getattr(value, n)) for n in names)
    if isinstance(value, (list, tuple)):
        return b"[" + b",".join(map(as_bytes, value)) + b"]"
    if isinstance(value, (set, frozenset)):
        return b"<" + b",".join(sorted(map(as_bytes, value))) + b">"
    if isinstance(value, Mapping):
        return b"{" + b",".join(as_bytes(k) + b":" + as_bytes(v) for k, v in value.items()) + b"}"
    return repr(value).encode()
