"""`constants=` of a state: SMACH writes them into the container's userdata before each execution of the state.

Where nobody can tell when that happens they are initial values of variables; elsewhere a state `set <key>` comes first.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from grip_bt.nodes.smach_asking import CONSTANT, MARK
from grip_bt.task import FrozenDict, Leaf
from grip_bt.task.model import AnyNode

from .found import Added, FoundContainer
from .keys import Keys, Variables, plain_literal


def constants_of(found: FoundContainer, added: Added) -> dict[str, Any]:
    """Return the constants of a state that a task can hold; what it can't is noted."""
    result: dict[str, Any] = {}
    for key, value in added.constants.items():
        try:
            result[key] = plain_literal(value)
        except ValueError as error:
            found.problem(
                "partial",
                f"the constant `{key}` of {added.label!r} is `{error}`, which only a run knows: "
                "give its variable a value, or have a state write it",
                added.span,
            )
    return result


def declare(found: FoundContainer, keys: Keys, variables: Variables) -> None:
    """Make those constants initial values that every reader is given alike and nobody writes."""
    for key, value in _plain(found):
        variables.values[keys(key)] = value


def steps_before(
    found: FoundContainer, keys: Keys, names: Mapping[str, str], taken: set[str]
) -> tuple[dict[str, AnyNode], dict[str, str]]:
    """Return the states that set constants, and label -> the state at which it begins.

    Args:
        found: the container.
        keys: its variables.
        names: label -> its state's name.
        taken: names that are used.
    """
    plain = {key for key, _ in _plain(found)}
    steps: dict[str, AnyNode] = {}
    entries = dict(names)
    for label, added in found.added.items():
        rest = {key: value for key, value in constants_of(found, added).items() if key not in plain}
        for key, value in reversed(rest.items()):
            name = f"set {key} of {names[label]}"
            while name in taken:
                name += "_"
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


def _plain(found: FoundContainer) -> Iterator[tuple[str, Any]]:
    """Yield constants whose moment nobody can tell: all who read the key have the same one, and it stays inside."""
    given = {label: constants_of(found, added) for label, added in found.added.items()}
    for key in dict.fromkeys(key for constants in given.values() for key in constants):
        values = [constants[key] for constants in given.values() if key in constants]
        if any(repr(value) != repr(values[0]) for value in values):
            continue
        if key in found.input_keys or key in found.output_keys or key in found.userdata:
            continue
        if _is_written(found, key) or any(key not in given[label] for label in _readers(found, key)):
            continue
        yield key, values[0]


def _is_written(found: FoundContainer, key: str) -> bool:
    return any(
        added.remapping.get(k, k) == key
        for added in found.added.values()
        for k in (*added.state.output_keys, *(() if added.state.kind else added.remapping))
    )


def _readers(found: FoundContainer, key: str) -> list[str]:
    return [
        label
        for label, added in found.added.items()
        if any(added.remapping.get(k, k) == key for k in added.state.input_keys)
    ]
