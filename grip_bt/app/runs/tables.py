"""What the events of a run, or of all runs of a task, add up to: times, failures, outcomes seen."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median

from grip_bt.app.project.catalogue import catalogue_of
from grip_bt.compilers.resolve import resolve
from grip_bt.runtime import Event, JournalReader

from .execute import check_task


@dataclass(frozen=True)
class Timing:
    """How long [s] the activations of a node took, on the run's clock, without those that were interrupted."""

    path: str
    count: int
    interrupted: int
    total: float
    median: float
    max: float


def timings(events: Iterable[Event]) -> list[Timing]:
    """Return the times of each node of a run, in the order in which they began first."""
    begun: dict[str, float] = {}
    taken: dict[str, list[float]] = {}
    halted: Counter[str] = Counter()
    for event in events:
        if event.event == "enter":
            begun[event.path] = event.t
            taken.setdefault(event.path, [])
        elif event.event == "exit" and event.path in begun:
            taken[event.path].append(event.t - begun.pop(event.path))
        elif event.event == "interrupted" and begun.pop(event.path, None) is not None:
            halted[event.path] += 1
    return [
        Timing(path, len(all), halted[path], sum(all), median(all) if all else 0.0, max(all, default=0.0))
        for path, all in taken.items()
    ]


def failures(events: Iterable[Event]) -> dict[tuple[str, str], tuple[int, str]]:
    """Return (leaf, reason's code) -> (how often, the last message) of a run, most often first.

    A container fails with the reason of a child, which is counted there.
    """
    entered: set[str] = set()
    counts: Counter[tuple[str, str]] = Counter()
    messages: dict[tuple[str, str], str] = {}
    for event in events:
        if event.event == "enter":
            entered.add(event.path)
        elif event.event == "exit" and event.code is not None:
            counts[event.path, event.code] += 1
            messages[event.path, event.code] = event.data.get("message", "")
    above = {"/"} if entered - {"/"} else set()
    for path in entered:
        parts = path.split("/")
        above.update("/".join(parts[:end]) for end in range(1, len(parts)))
    return {key: (count, messages[key]) for key, count in counts.most_common() if key[0] not in above}


@dataclass(frozen=True)
class Coverage:
    """Which outcomes of a task's nodes were seen in its runs.

    Attributes:
        seen: node -> outcome -> how often, for outcomes that were seen.
        missing: node -> outcomes that weren't.
        codes: (node, outcome) -> failure codes that were seen, with how often.
    """

    runs: int
    seen: Mapping[str, Mapping[str, int]]
    missing: Mapping[str, Sequence[str]]
    codes: Mapping[tuple[str, str], Mapping[str, int]]

    @property
    def counts(self) -> tuple[int, int]:
        """How many outcomes were seen, and how many there are."""
        seen = sum(map(len, self.seen.values()))
        return seen, seen + sum(map(len, self.missing.values()))


def coverage(reader: JournalReader, task: str) -> Coverage:
    """Look through all runs of a task, by its name, for the outcomes that its nodes have now.

    Raises:
        DocumentError, InvalidTaskError: the task can't be read or is wrong.
    """
    project, document, _ = check_task(task)
    parts = resolve(document.task, catalogue_of(project)).root.walk()
    wanted = {part.path: list(part.meaning) for part in parts}
    records = [record for record in reader.runs() if record.task_name == document.task.name]
    counts: dict[str, Counter[str]] = {path: Counter() for path in wanted}
    codes: dict[tuple[str, str], Counter[str]] = {}
    for record in records:
        for event in reader.events(record.id):
            if event.event == "exit" and event.outcome is not None and event.outcome in wanted.get(event.path, ()):
                counts[event.path][event.outcome] += 1
                if event.code is not None:
                    codes.setdefault((event.path, event.outcome), Counter())[event.code] += 1
    missing = {path: [o for o in outcomes if o not in counts[path]] for path, outcomes in wanted.items()}
    return Coverage(
        len(records),
        {path: dict(found) for path, found in counts.items() if found},
        {path: outcomes for path, outcomes in missing.items() if outcomes},
        {key: dict(found) for key, found in codes.items()},
    )
