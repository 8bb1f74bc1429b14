"""Concurrence -> parallel that joins, whose rules are the outcome map; refused by name where callbacks decide.

SMACH takes the entry with most conditions that hold, the first of equals; a parallel the first rule that holds. So the
rules are the entries by length, and the default outcome comes last.
"""

from __future__ import annotations

from dataclasses import dataclass

from .found import FoundContainer


class RefusedError(Exception):
    """A container has no equal among the kinds of a task; the message says why."""


@dataclass
class Plan:
    """How a Concurrence becomes a parallel.

    Attributes:
        rules: outcome of the Concurrence, and child -> outcome for which it is; the first that holds decides.
        default: its outcome where none holds.
    """

    rules: list[tuple[str, dict[str, str]]]
    default: str


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
    if default not in (found.outcomes or ()):
        raise RefusedError(f"its default outcome {default!r} is none of its outcomes")
    entries = {k: dict(v) for k, v in mapped.items() if isinstance(v, dict) and v}
    if len(entries) != len(mapped):
        raise RefusedError("an entry of its outcome map is empty, or known only by a run")
    for label, wanted in entries.items():
        if unknown := sorted(set(wanted) - set(found.added)):
            raise RefusedError(f"its outcome map names {unknown}, which it doesn't hold")
        if label not in (found.outcomes or ()):
            raise RefusedError(f"{label!r} of its outcome map is none of its outcomes")
    _check_writes(found)
    return Plan(sorted(entries.items(), key=lambda entry: -len(entry[1])), default)


def _check_writes(found: FoundContainer) -> None:
    writers: dict[str, str] = {}
    for label, added in found.added.items():
        for key in added.state.output_keys:
            there = added.remapping.get(key, key)
            if there in writers and writers[there] != label:
                raise RefusedError(f"{writers[there]!r} and {label!r} both write the userdata `{there}`")
            writers[there] = label
