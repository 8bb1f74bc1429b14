"""Children that run at the same time and share variables."""

from __future__ import annotations

from grip_bt.graph import Parallel

from ..survey import Spot, Survey


def check_parallel(survey: Survey) -> None:
    """Find variables that two children of a parallel write, or that one writes and another reads."""
    for spot in survey.spots:
        if isinstance(spot.node, Parallel):
            _shared(survey, spot)


def _shared(survey: Survey, spot: Spot) -> None:
    children = list(spot.children.values())
    written = read = twice = mixed = 0
    for child in children:
        twice |= written & child.writes
        mixed |= (written & child.reads) | (read & child.writes)
        written |= child.writes
        read |= child.reads
    for declared in survey.declared:
        if declared.bit & twice:
            writers = [c.name for c in children if c.writes & declared.bit]
            survey.add(
                spot.path,
                "children",
                "parallel-writes",
                f"the children {', '.join(writers)} write {declared.name!r} at the same time",
                "give each a variable of its own",
            )
        elif declared.bit & mixed:
            writer = next(c.name for c in children if c.writes & declared.bit)
            reader = next(c.name for c in children if c.reads & declared.bit and c.name != writer)
            survey.add(
                spot.path,
                "children",
                "parallel-read-write",
                f"{reader!r} reads {declared.name!r} while {writer!r} writes it",
                f"read another variable, or put {writer!r} before the parallel",
            )
