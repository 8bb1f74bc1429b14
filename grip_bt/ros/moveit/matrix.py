"""MoveIt's matrix of allowed collisions: what move_group began with, and what a task allows beyond that.

What a task allows and forbids again is as it was before: pairs that the robot's SRDF allows stay allowed.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from grip_bt.commanders.scene import ANYTHING

from ..types import load_type


def with_allowed(baseline: Any, pairs: Iterable[tuple[str, str]], names: Iterable[str]) -> Any:
    """Return a matrix that allows `pairs` besides what `baseline` does.

    Args:
        baseline: a `moveit_msgs/msg/AllowedCollisionMatrix`; left as it is.
        pairs: of names of links and objects; `*` stands for all.
        names: further names of links and objects, for `*`.
    """
    pairs = list(pairs)
    known = list(dict.fromkeys([*baseline.entry_names, *names, *(n for p in pairs for n in p if n != ANYTHING)]))
    allowed = {
        pair
        for one, other in pairs
        for a in _meant(one, known)
        for b in _meant(other, known)
        for pair in ((a, b), (b, a))
    }
    rows = {name: row.enabled for name, row in zip(baseline.entry_names, baseline.entry_values, strict=False)}
    column = {name: i for i, name in enumerate(baseline.entry_names)}
    default = dict(zip(baseline.default_entry_names, baseline.default_entry_values, strict=False))

    def may(one: str, other: str) -> bool:
        if (one, other) in allowed:
            return True
        if one in rows and other in column:
            return bool(rows[one][column[other]])
        said = [default[name] for name in (one, other) if name in default]
        return bool(said) and all(said)

    entry = load_type("moveit_msgs/msg/AllowedCollisionEntry")
    return load_type("moveit_msgs/msg/AllowedCollisionMatrix")(
        entry_names=known,
        entry_values=[entry(enabled=[may(one, other) for other in known]) for one in known],
        default_entry_names=list(baseline.default_entry_names),
        default_entry_values=list(baseline.default_entry_values),
    )


def _meant(name: str, known: list[str]) -> list[str]:
    return known if name == ANYTHING else [name]
