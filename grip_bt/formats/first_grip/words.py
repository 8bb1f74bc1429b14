"""What labels, groups and outcomes of the first GRIP are called here, and what outcomes mean."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from grip_bt.formats.names import free, node_name
from grip_bt.task.model import Meaning

_BAD = ("fail", "abort", "error", "none", "preempt")


def name_of(label: str, taken: Collection[str] = ()) -> str:
    """Return a label as a task may spell it, none of those that are taken."""
    return free(node_name(label), taken)


def outcome_meanings(outcomes: Sequence[str]) -> dict[str, Meaning]:
    """Return what outcomes mean: the first is good, the last of several bad, others by their names."""
    found: dict[str, Meaning] = {}
    for number, outcome in enumerate(outcomes):
        bad = any(word in outcome.lower() for word in _BAD)
        last = number == len(outcomes) - 1
        found[outcome] = "success" if number == 0 or not (bad or last) else "failure"
    return found


def is_hand(group: str) -> bool:
    """Tell whether a group of joints is a hand, by its name."""
    return any(word in group.lower() for word in ("hand", "gripper", "finger")) and "arm" not in group.lower()
