"""Concurrence -> parallel, where a parallel that joins does the same; refused by name elsewhere.

A parallel looks at its exits (one child's outcome each, in the children's order), then at the meanings of the
children's ends: all success, or not. An outcome map fits that when at most one entry names several children, and no
entry that a parallel looks at first is one that SMACH would look at later.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

from grip_bt.nodes.smach_leaf import task_name

from .found import FoundContainer


class RefusedError(Exception):
    """A container has no equal among the kinds of a task; the message says why."""


@dataclass
class Plan:
    """How a Concurrence becomes a parallel.

    Attributes:
        order: the children's labels, as the parallel holds them.
        wanted: child -> the outcome that counts as success; children that aren't here always succeed.
        exits: (child, outcome) -> an outcome of the parallel.
        ends: outcome of the parallel -> outcome of the Concurrence.
    """

    order: list[str]
    wanted: dict[str, str] = field(default_factory=dict)
    exits: dict[tuple[str, str], str] = field(default_factory=dict)
    ends: dict[str, str] = field(default_factory=dict)


def plan_of(found: FoundContainer) -> Plan:
    """Return how a Concurrence becomes a parallel.

    Raises:
        RefusedError: it can't, exactly.
    """
    settings = found.settings
    for name in ("child_termination_cb", "outcome_cb"):
        if settings.get(name) is not None:
            raise RefusedError(f"its `{name}` decides in its own way when it ends or how")
    default, mapped = settings.get("default_outcome"), settings.get("outcome_map") or {}
    if not isinstance(default, str) or not isinstance(mapped, dict):
        raise RefusedError("its default outcome or outcome map is known only by a run")
    entries = {k: dict(v) for k, v in mapped.items() if isinstance(v, dict) and v}
    if len(entries) != len(mapped):
        raise RefusedError("an entry of its outcome map is empty, or known only by a run")
    for label, wanted in entries.items():
        if unknown := sorted(set(wanted) - set(found.added)):
            raise RefusedError(f"its outcome map names {unknown}, which it doesn't hold")
        if label not in (found.outcomes or ()):
            raise RefusedError(f"{label!r} of its outcome map is none of its outcomes")
    _check_writes(found)
    several = {k: v for k, v in entries.items() if len(v) > 1}
    if len(several) > 1:
        raise RefusedError(f"more than one entry of its outcome map names several children: {sorted(several)}")
    return _plan(found, default, several, {k: v for k, v in entries.items() if len(v) == 1})


def _plan(
    found: FoundContainer, default: str, several: dict[str, dict[str, str]], single: dict[str, dict[str, str]]
) -> Plan:
    plan = Plan(_order(found, single))
    success = default
    for label, wanted in several.items():
        plan.wanted, success = dict(wanted), label
    if not several and len(single) == 1:
        ((success, wanted),) = single.items()
        plan.wanted, single = dict(wanted), {}
    for label, wanted in single.items():
        ((child, outcome),) = wanted.items()
        if plan.wanted.get(child, outcome) == outcome and several:
            raise RefusedError(f"the entry {label!r} of its outcome map can hold together with a longer one")
        name = task_name(label)
        name = f"{name}_" if name in ("success", "failure") else name
        plan.exits[child, outcome] = name
        plan.ends[name] = label
    plan.ends["success"] = success
    plan.ends["failure"] = default
    return plan


def _order(found: FoundContainer, single: dict[str, dict[str, str]]) -> list[str]:
    """Return the children so that exits are looked at as the map is: its first entry that holds wins a tie."""
    first = list(dict.fromkeys(child for wanted in single.values() for child in wanted))
    positions = [next(iter(wanted)) for wanted in single.values()]
    if any(a != b and positions[i + 1 :].count(a) for i, (a, b) in enumerate(itertools.pairwise(positions))):
        raise RefusedError("the order of its outcome map goes back and forth between children")
    return [*first, *(label for label in found.added if label not in first)]


def _check_writes(found: FoundContainer) -> None:
    writers: dict[str, str] = {}
    for label, added in found.added.items():
        for key in added.state.output_keys:
            there = added.remapping.get(key, key)
            if there in writers and writers[there] != label:
                raise RefusedError(f"{writers[there]!r} and {label!r} both write the userdata `{there}`")
            writers[there] = label
