"""What the outcomes of legacy code mean, by their names; a person may correct it in the task."""

from __future__ import annotations

from collections.abc import Iterable

from grip_bt.task import Meaning

_SUCCESS = frozenset(
    (
        *("succeeded", "succeed", "success", "successful", "successfully", "done", "true", "valid", "finished"),
        *("finish", "arrived", "ok", "okay", "yes", "complete", "completed", "found", "reached", "exhausted"),
    )
)


def meaning_of(label: str) -> Meaning:
    """Return what an outcome of this name means."""
    return "success" if label.strip().lower() in _SUCCESS else "failure"


def meanings_of(labels: Iterable[str]) -> dict[str, Meaning]:
    """Return the meanings of outcomes."""
    return {label: meaning_of(label) for label in labels}
