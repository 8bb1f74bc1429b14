"""Names and meanings: what labels, groups and outcomes of the first GRIP are called here."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

from grip_bt.task.model import Meaning

_BAD = ("fail", "abort", "error", "none", "preempt")


def name_of(label: str, taken: Collection[str] = ()) -> str:
    """Return a label as a task may spell it, none of those that are taken."""
    name = re.sub(r"[^A-Za-z0-9_ -]", "_", label).strip() or "_"
    name = name if name[0].isalpha() or name[0] == "_" else f"_{name}"
    while name in taken:
        name += "_"
    return name


def key_of(label: str) -> str:
    """Return a name of a group, sensor or component as a key: lower case, words joined by `_`."""
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", label)
    key = re.sub(r"[^A-Za-z0-9]+", "_", words).strip("_").lower()
    return key if key[:1].isalpha() else f"the_{key}".rstrip("_")


def meanings(outcomes: Sequence[str]) -> dict[str, Meaning]:
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
