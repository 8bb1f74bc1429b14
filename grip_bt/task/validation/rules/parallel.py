"""Children that run at the same time and share variables."""

from __future__ import annotations

from grip_bt.base.errors import listing, nearest
from grip_bt.task import Parallel

from ..survey import Key, Spot, Survey
from .outcomes import check_label, unknown_target


def check_parallel(survey: Survey) -> None:
    """Find variables that two children of a parallel write, or that one writes and another reads."""
    for spot in survey.containers:
        if isinstance(spot.node, Parallel):
            _rules(survey, spot, spot.node)
            if spot.node.order is None:
                _shared(survey, spot)


def _rules(survey: Survey, spot: Spot, node: Parallel) -> None:
    for name in node.wait_for if isinstance(node.wait_for, list) else ():
        _child(survey, spot, "wait_for", name)
    for number, rule in enumerate(node.rules):
        where = ("rules", number)
        if rule.then not in spot.outcomes:
            unknown_target(survey, spot.path, (*where, "then"), rule.then, spot.outcomes, "outcomes of this container")
        for name, said in rule.when.items():
            child = _child(survey, spot, (*where, "when", name), name)
            for label in [said] if isinstance(said, str) else said:
                if child is not None:
                    check_label(survey, spot.path, (*where, "when", name), child, label)


def _child(survey: Survey, spot: Spot, where: Key, name: str) -> Spot | None:
    child = spot.children.get(name)
    if child is None:
        hint = nearest(name, spot.children)
        survey.add(
            spot.path, where, "unknown-child", f"{name!r} is no child{hint} (there are: {listing(spot.children)})"
        )
    return child


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
                "give each a variable of its own, or say `order: declared`",
            )
        elif declared.bit & mixed:
            writer = next(c.name for c in children if c.writes & declared.bit)
            reader = next(c.name for c in children if c.reads & declared.bit and c.name != writer)
            survey.add(
                spot.path,
                "children",
                "parallel-read-write",
                f"{reader!r} reads {declared.name!r} while {writer!r} writes it",
                f"read another variable, put {writer!r} before the parallel, or say `order: declared`",
            )
