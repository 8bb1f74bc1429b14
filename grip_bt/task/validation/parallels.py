"""Parallels: what they wait for and go by, and variables that their children use at the same time."""

from __future__ import annotations

from grip_bt.base.errors import listing, nearest
from grip_bt.task import Parallel

from .analysis import Key, PlacedNode, TaskAnalysis
from .outcomes import check_label, unknown_target


def check_parallel(analysis: TaskAnalysis) -> None:
    """Find variables that two children of a parallel write, or that one writes and another reads."""
    for placed in analysis.containers:
        if isinstance(placed.node, Parallel):
            _rules(analysis, placed, placed.node)
            if placed.node.order is None:
                _shared(analysis, placed)


def _rules(analysis: TaskAnalysis, placed: PlacedNode, node: Parallel) -> None:
    for name in node.wait_for if isinstance(node.wait_for, list) else ():
        _child(analysis, placed, "wait_for", name)
    for number, rule in enumerate(node.rules):
        where = ("rules", number)
        if rule.then not in placed.outcomes:
            unknown_target(
                analysis, placed.path, (*where, "then"), rule.then, placed.outcomes, "outcomes of this container"
            )
        for name, said in rule.when.items():
            child = _child(analysis, placed, (*where, "when", name), name)
            for label in [said] if isinstance(said, str) else said:
                if child is not None:
                    check_label(analysis, placed.path, (*where, "when", name), child, label)


def _child(analysis: TaskAnalysis, placed: PlacedNode, where: Key, name: str) -> PlacedNode | None:
    child = placed.children.get(name)
    if child is None:
        hint = nearest(name, placed.children)
        analysis.add(
            placed.path, where, "unknown-child", f"{name!r} isn't a child{hint} (available: {listing(placed.children)})"
        )
    return child


def _shared(analysis: TaskAnalysis, placed: PlacedNode) -> None:
    children = list(placed.children.values())
    written = read = twice = mixed = 0
    for child in children:
        twice |= written & child.writes
        mixed |= (written & child.reads) | (read & child.writes)
        written |= child.writes
        read |= child.reads
    for declared in analysis.declared:
        if declared.bit & twice:
            writers = [c.name for c in children if c.writes & declared.bit]
            message = f"the children {', '.join(writers)} write {declared.name!r} at the same time"
            fix = "give each a variable of its own, or say `order: declared`"
            analysis.add(placed.path, "children", "parallel-writes", message, fix)
        elif declared.bit & mixed:
            writer = next(c.name for c in children if c.writes & declared.bit)
            reader = next(c.name for c in children if c.reads & declared.bit and c.name != writer)
            message = f"{reader!r} reads {declared.name!r} while {writer!r} writes it"
            fix = f"read another variable, put {writer!r} before the parallel, or say `order: declared`"
            analysis.add(placed.path, "children", "parallel-read-write", message, fix)
