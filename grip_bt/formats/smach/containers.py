"""Containers as a task has them: meanings of outcomes, rules of a Concurrence, items of an Iterator, constants."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from grip_bt.formats.names import free
from grip_bt.nodes.smach_asking import CONSTANT, MARK
from grip_bt.nodes.smach_leaf import task_name
from grip_bt.task import FrozenDict, Leaf
from grip_bt.task.model import AnyNode, Meaning

from .found import Child, ContainerInfo, Value
from .leaves import Meanings
from .userdata import Keys, Variables, plain_literal


class RefusedError(Exception):
    """A container has no equivalent among the kinds of a task; the message says why."""


Rules = list[tuple[str, dict[str, str]]]


def parallel_rules(found: ContainerInfo) -> tuple[Rules, str]:
    """Return how a Concurrence becomes a parallel.

    Returns:
        Outcomes of the Concurrence, with child -> outcome for which it is, where the first that holds decides; and its
        outcome where none holds.

    Raises:
        RefusedError: it can't, exactly.
    """
    settings = found.settings
    for name in ("child_termination_cb", "outcome_cb"):
        if settings.get(name):
            raise RefusedError(f"its `{name}` decides in its own way when it ends or how")
    default, mapped = settings.get("default_outcome"), settings.get("outcome_map") or {}
    if not isinstance(default, str) or not isinstance(mapped, dict):
        raise RefusedError("its default outcome or outcome map is known only at run time")
    if default not in (found.outcomes or ()):
        raise RefusedError(f"its default outcome {default!r} is none of its outcomes")
    entries = {k: dict(v) for k, v in mapped.items() if isinstance(v, dict) and v}
    if len(entries) != len(mapped):
        raise RefusedError("an entry of its outcome map is empty, or known only at run time")
    for label, wanted in entries.items():
        if unknown := sorted(set(wanted) - set(found.added)):
            raise RefusedError(f"its outcome map names {unknown}, which it doesn't hold")
        if label not in (found.outcomes or ()):
            raise RefusedError(f"{label!r} of its outcome map is none of its outcomes")
    writers: dict[str, str] = {}
    for label, added in found.added.items():
        for key in added.state.output_keys:
            there = added.remapping.get(key, key)
            if there in writers and writers[there] != label:
                raise RefusedError(f"{writers[there]!r} and {label!r} both write the userdata `{there}`")
            writers[there] = label
    return sorted(entries.items(), key=lambda entry: -len(entry[1])), default


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
        """Return what it ends with when it is preempted in an item, and after which outcomes of the contained state.

        That may be none of its outcomes.
        """
        result: dict[str, list[str]] = {}
        for outcome in sorted(self.loops):
            result.setdefault(self.mapped.get(outcome, outcome), []).append(outcome)
        return list(result.items())


def iteration_of(found: ContainerInfo) -> Iteration:
    """Return what an Iterator does.

    Raises:
        RefusedError: it isn't known, or leads nowhere.
    """
    settings = found.settings
    if len(found.added) != 1:
        raise RefusedError("it needs exactly one contained state")
    (added,) = found.added.values()
    try:
        items = plain_literal(found.items or Value(value=[]))
    except ValueError as error:
        raise RefusedError(f"its items are `{error}`, known only at run time") from None
    label, exhausted = settings.get("it_label", "it_data"), settings.get("exhausted_outcome", "exhausted")
    loop, leave = settings.get("loop_outcomes") or [], settings.get("break_outcomes") or []
    mapped = settings.get("final_outcome_map") or {}
    known = added.state.outcomes or []
    words = (*loop, *leave, *mapped, *mapped.values(), label, exhausted)
    if not isinstance(items, list) or not all(isinstance(word, str) for word in words):
        raise RefusedError("its items, outcomes or outcome map are known only at run time")
    # upstream's rule: with a break list, the rest loops; without, whatever isn't in the loop list breaks
    loops = frozenset(o for o in known if (o not in leave if leave else o in loop))
    final = {o: mapped.get(o, o) for o in known if o not in loops}
    for target in (*final.values(), mapped.get(exhausted, exhausted)):
        if target not in (found.outcomes or ()):
            raise RefusedError(f"it would end with {target!r}, which is none of its outcomes")
    return Iteration(items, label, loops, final, mapped.get(exhausted, exhausted), dict(mapped))


def check(found: ContainerInfo) -> None:
    """Refuse what no machine can be made of.

    Raises:
        RefusedError: the container wasn't read well enough, or SMACH would refuse it too.
    """
    if failed := [issue for issue in found.issues if issue.severity == "error"]:
        raise RefusedError(failed[0].message)
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


def meanings(found: ContainerInfo, means_by_name: Meanings) -> dict[str, Meaning]:
    """Return outcome, as a task spells it -> what it means.

    Raises:
        RefusedError: one called as a meaning would mean the other.
    """
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


def constants_of(found: ContainerInfo, added: Child) -> dict[str, object]:
    """Return the constants of a state that a task can hold; what it can't is noted."""
    result: dict[str, object] = {}
    for key, value in added.constants.items():
        try:
            result[key] = plain_literal(value)
        except ValueError as error:
            text = f"the constant `{key}` of {added.label!r} is `{error}`, known only at run time: "
            found.problem("partial", text + "give its variable a value, or have a state write it", added.span)
    return result


def declare(found: ContainerInfo, keys: Keys, variables: Variables) -> None:
    """Make those constants initial values that every reader is given alike and nobody writes."""
    for key, value in _plain(found):
        variables.values[keys(key)] = value


def steps_before(
    found: ContainerInfo, keys: Keys, names: Mapping[str, str], taken: set[str]
) -> tuple[dict[str, AnyNode], dict[str, str]]:
    """Return the states that set constants, and label -> the state at which it begins.

    Args:
        names: label -> its state's name.
        taken: names that are used.
    """
    plain = {key for key, _ in _plain(found)}
    steps: dict[str, AnyNode] = {}
    entries = dict(names)
    for label, added in found.added.items():
        rest = {key: value for key, value in constants_of(found, added).items() if key not in plain}
        for key, value in reversed(rest.items()):
            name = free(f"set {key} of {names[label]}", taken)
            taken.add(name)
            steps[name] = Leaf(
                node="flow/set",
                with_={"value": value},
                out={"value": keys(key)},
                on={"success": entries[label]},
                x={MARK: CONSTANT},
            )
            entries[label] = name
    return steps, entries


def led_to(node: AnyNode, entries: Mapping[str, str], names: Mapping[str, str]) -> AnyNode:
    """Return a state whose edges lead to where others begin."""
    begins = {names[label]: entry for label, entry in entries.items()}
    return node.model_copy(update={"on": FrozenDict({o: begins.get(to, to) for o, to in node.on.items()})})


def _plain(found: ContainerInfo) -> Iterator[tuple[str, object]]:
    """Yield constants whose moment nobody can tell: all who read the key have the same one, and it stays inside."""
    given = {label: constants_of(found, added) for label, added in found.added.items()}
    for key in dict.fromkeys(key for constants in given.values() for key in constants):
        values = [constants[key] for constants in given.values() if key in constants]
        if any(repr(value) != repr(values[0]) for value in values):
            continue
        if key in found.input_keys or key in found.output_keys or key in found.userdata:
            continue
        for label, added in found.added.items():
            state, remapped = added.state, added.remapping
            written = (*state.output_keys, *(() if state.kind else remapped))
            read = any(remapped.get(k, k) == key for k in state.input_keys)
            if any(remapped.get(k, k) == key for k in written) or (read and key not in given[label]):
                break
        else:
            yield key, values[0]
