"""What a container declares, as a task says it: outcomes with their meanings, and where it comes from."""

from __future__ import annotations

from typing import Any

from grip_bt.nodes.smach_asking import MARK
from grip_bt.nodes.smach_leaf import task_name
from grip_bt.task.model import Meaning

from .concurrence import RefusedError
from .found import FoundContainer
from .meanings import meaning_of


def check(found: FoundContainer) -> None:
    """Refuse what no machine can be made of.

    Raises:
        RefusedError: the container wasn't read well enough, or SMACH would refuse it too.
    """
    if failed := [p for p in found.problems if p.verdict == "failed"]:
        raise RefusedError(failed[0].text)
    if not found.outcomes:
        raise RefusedError("its outcomes aren't known")
    if not found.added:
        raise RefusedError("nothing is added to it")
    for label, added in found.added.items():
        known = added.state.outcomes
        if known and (wrong := sorted(set(added.transitions) - set(known))):
            raise RefusedError(f"{label!r} has transitions for {wrong}, but {added.state.cls} ends with {known}")
    if found.kind in ("StateMachine", "Sequence") and found.initial not in found.added:
        raise RefusedError(f"its initial state {found.initial!r} isn't there")


def meanings(found: FoundContainer) -> dict[str, Meaning]:
    """Return outcome, as a task spells it -> what it means.

    Raises:
        RefusedError: one called as a meaning would mean the other.
    """
    means = {task_name(o): meaning_of(o) for o in found.outcomes or ()}
    if wrong := [o for o in ("success", "failure") if o in means and means[o] != o]:
        raise RefusedError(f"its outcome {wrong[0]!r} would have to mean the opposite")
    return means


def labelled(found: FoundContainer, default: str) -> tuple[dict[str, Meaning], dict[str, str]]:
    """Return the outcomes that a parallel declares, and what each outcome is called: one `success`, one `failure`."""
    meanings(found)
    outcomes = list(dict.fromkeys((default, *(found.outcomes or ()))))
    labels: dict[str, str] = {o: o for o in outcomes if o in ("success", "failure")}
    for outcome in outcomes:
        if outcome not in labels and meaning_of(outcome) not in labels.values():
            labels[outcome] = meaning_of(outcome)
    own = {o: task_name(o) for o in outcomes if o not in labels}
    return {name: meaning_of(o) for o, name in own.items()}, {**labels, **own}


def source_of(found: FoundContainer) -> dict[str, Any]:
    """Return the marks of a container: where it comes from, and what it was."""
    return {"x-source": str(found.span), MARK: found.kind}
