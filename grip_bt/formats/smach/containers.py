"""Containers as a task has them: meanings of outcomes, rules of a Concurrence, items of an Iterator."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from grip_bt.nodes.smach_asking import MARK
from grip_bt.nodes.smach_leaf import task_name
from grip_bt.task.model import Meaning

from .found import ContainerInfo, Value
from .leaves import Meanings
from .userdata import plain_literal


class RefusedError(Exception):
    """A container has no equivalent among the kinds of a task; the message says why."""


Rules = list[tuple[str, dict[str, str]]]


def parallel_rules(found: ContainerInfo) -> tuple[Rules, str]:
    """Return (outcome, {child: outcome}) of a Concurrence, where the first that holds decides, and its outcome else."""
    settings = found.settings
    for name in ("child_termination_cb", "outcome_cb"):
        if settings.get(name):
            raise RefusedError(f"its `{name}` decides in its own way when it ends or how")
    entries: dict[str, dict[str, str]] = settings["outcome_map"]
    if not all(entries.values()):
        raise RefusedError("an entry of its outcome map is empty")
    for wanted in entries.values():
        if unknown := sorted(set(wanted) - set(found.added)):
            raise RefusedError(f"its outcome map names {unknown}, which it doesn't hold")
    writers: dict[str, str] = {}
    for label, added in found.added.items():
        for key in added.state.output_keys:
            there = added.remapping.get(key, key)
            if there in writers and writers[there] != label:
                raise RefusedError(f"{writers[there]!r} and {label!r} both write the userdata `{there}`")
            writers[there] = label
    return sorted(entries.items(), key=lambda entry: -len(entry[1])), settings["default_outcome"]


@dataclass(frozen=True)
class Iteration:
    """What an Iterator does after outcomes of the contained state: the next item comes, or it ends with an outcome.

    `label` is the userdata that holds the item, `mapped` its `final_outcome_map`.
    """

    items: list[Any]
    label: str
    loops: frozenset[str]
    final: dict[str, str]
    exhausted: str
    mapped: dict[str, str]

    def interrupted(self) -> list[tuple[str, list[str]]]:
        """Return what it ends with when preempted in an item, not always one of its own, after which of its state's."""
        result: dict[str, list[str]] = {}
        for outcome in sorted(self.loops):
            result.setdefault(self.mapped.get(outcome, outcome), []).append(outcome)
        return list(result.items())


def iteration_of(found: ContainerInfo) -> Iteration:
    """Return what an Iterator does; refuse one of which it isn't known, or that leads nowhere."""
    settings = found.settings
    if len(found.added) != 1:
        raise RefusedError("it needs exactly one contained state")
    (added,) = found.added.values()
    try:
        items = plain_literal(found.items or Value(value=[]))
    except ValueError as error:
        raise RefusedError(f"its items are `{error}`, known only at run time") from None
    if not isinstance(items, list):
        raise RefusedError("its items are no list")
    loop, leave, mapped = settings["loop_outcomes"], settings["break_outcomes"], settings["final_outcome_map"]
    exhausted = settings["exhausted_outcome"]
    known = added.state.outcomes
    # upstream's rule: with a break list, the rest loops; without, whatever isn't in the loop list breaks
    loops = frozenset(o for o in known if (o not in leave if leave else o in loop))
    final = {o: mapped.get(o, o) for o in known if o not in loops}
    for target in (*final.values(), mapped.get(exhausted, exhausted)):
        if target not in (found.outcomes or ()):
            raise RefusedError(f"it would end with {target!r}, which is none of its outcomes")
    return Iteration(items, settings["it_label"], loops, final, mapped.get(exhausted, exhausted), dict(mapped))


def check(found: ContainerInfo) -> None:
    """Refuse what wasn't read well enough, and what SMACH would refuse too."""
    if failed := [issue for issue in found.issues if issue.severity == "error"]:
        raise RefusedError(failed[0].message)
    if not found.outcomes:
        raise RefusedError("its outcomes aren't known")
    if not found.added:
        raise RefusedError("nothing is added to it")
    for label, added in found.added.items():
        if added.constants:
            raise RefusedError(f"{label!r} has constants, which SMACH writes before each execution")
        known = added.state.outcomes
        if known and (wrong := sorted(set(added.transitions) - set(known))):
            raise RefusedError(f"{label!r} has transitions for {wrong}, but {added.state.cls} ends with {known}")
    if found.kind in ("StateMachine", "Sequence") and found.initial not in found.added:
        raise RefusedError(f"its initial state {found.initial!r} isn't there")


def meanings(found: ContainerInfo, means_by_name: Meanings) -> dict[str, Meaning]:
    """Return outcome, as a task spells it -> what it means; refuse one called `success` that would mean the other."""
    means = {task_name(o): meaning for o, meaning in means_by_name.of(found.outcomes or ()).items()}
    if wrong := [o for o in ("success", "failure") if o in means and means[o] != o]:
        raise RefusedError(f"its outcome {wrong[0]!r} would have to mean the opposite")
    return means


def labelled(found: ContainerInfo, default: str, means_by_name: Meanings) -> tuple[dict[str, Meaning], dict[str, str]]:
    """Return the outcomes that a parallel declares, and what each outcome is called: one `success`, one `failure`."""
    meanings(found, means_by_name)
    outcomes = list(dict.fromkeys((default, *(found.outcomes or ()))))
    means = means_by_name.of(outcomes)
    labels: dict[str, str] = {o: o for o in outcomes if o in ("success", "failure")}
    for outcome in outcomes:
        if outcome not in labels and means[outcome] not in labels.values():
            labels[outcome] = means[outcome]
    own = {o: task_name(o) for o in outcomes if o not in labels}
    return {name: means[o] for o, name in own.items()}, {**labels, **own}


def source_of(found: ContainerInfo) -> dict[str, object]:
    """Return the marks of a container: where it comes from, and what it was."""
    return {"x-source": str(found.span), MARK: found.kind}
