"""Containers whose children run one after the other, as transitions: where each end of each child leads.

An end that carries a failure code gets a label of its own, `failure.no_ik`, where an edge here or further out uses it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from grip_bt.task import model

from .behaviour_state import Refined
from .resolve import Part

COUNT = "again?"
"""Label of the state that counts attempts, or chooses who is next; no node's name can contain the question mark."""


@dataclass(frozen=True)
class Lead:
    """Where an end leads: to the child `to`, or out by the outcome `end`."""

    to: str | None = None
    end: str | None = None


@dataclass
class Table:
    """Transitions of one container.

    Attributes:
        rows: child -> label of its end -> where it leads; in order, the first child is the initial one.
        refined: child -> (outcome, code) pairs that need a label.
    """

    rows: dict[str, dict[str, str]] = field(default_factory=dict)
    refined: dict[str, set[tuple[str, str]]] = field(default_factory=dict)
    initial: str = ""


def interrupts(part: Part) -> bool:
    """Tell whether the container may interrupt a running child, or has none: no blocking states are equal to it."""
    match part.node:
        case model.Sequence(memory=memory) | model.Fallback(memory=memory):
            return not memory or not part.children
        case model.Parallel(cancel=cancel, order=order):
            return cancel != "join" or order is not None or not part.children
        case model.Switch(memory=memory):
            return not memory
        case model.Timeout() | model.Guard():
            return True
    return False


def chooses(part: Part) -> bool:
    """Tell whether a rule chooses the child that comes next."""
    return not interrupts(part) and isinstance(part.node, (model.Switch, model.Loop, model.ForEach, model.Cooldown))


def counts(part: Part) -> bool:
    """Tell whether attempts are counted."""
    return isinstance(part.node, model.Retry) or (isinstance(part.node, model.Repeat) and part.node.times is not None)


def state_labels(part: Part) -> dict[str, str]:
    """Return child -> label of its state.

    It is the child's name, unless that is an outcome of the container too: in smach a target that names both is the
    state, and only in a state machine does the document mean that.
    """
    if isinstance(part.node, model.StateMachine):
        return {child.name: child.name for child in part.children}
    taken = {child.name for child in part.children} | set(part.meaning)
    result = {}
    for child in part.children:
        name = child.name
        while name != child.name and name in taken or name in part.meaning:
            name += "'"
        result[child.name] = name
    return result


def table_of(part: Part, needed: Refined) -> Table:
    """Return the transitions of a container that doesn't interrupt.

    Args:
        part: the container.
        needed: its own (outcome, code) pairs for which its parent needs a label.
    """
    table, names = Table(), state_labels(part)
    own = part.edges if isinstance(part.node, model.StateMachine) else part.exits
    for index, child in enumerate(part.children):
        row: dict[str, str] = {}
        refined: set[tuple[str, str]] = set()
        for outcome in child.meaning:
            row[outcome] = _target(lead(part, index, outcome, None), names)
            mine = set(own.codes(child.name, outcome))
            for code in sorted(mine | {code for _, code in needed}):
                way = lead(part, index, outcome, code)
                carried = way.end is not None and (way.end, code) in needed and part.meaning[way.end] == "failure"
                if carried or code in mine:
                    refined.add((outcome, code))
                    row[f"{outcome}.{code}"] = f"{way.end}.{code}" if carried else _target(way, names)
        table.rows[names[child.name]], table.refined[child.name] = row, refined
    table.initial = COUNT if chooses(part) else names[_initial(part)]
    return table


def lead(part: Part, index: int, outcome: str, code: str | None) -> Lead:
    """Return where the end of the child at `index` leads."""
    child = part.children[index]
    if isinstance(part.node, model.StateMachine):
        target = part.edges.target(child.name, outcome, code)
        assert target is not None, "every end of a state has an edge"
        return Lead(to=target) if any(c.name == target for c in part.children) else Lead(end=target)
    taken = part.exits.target(child.name, outcome, code)
    if taken is not None:
        return Lead(end=taken)
    return _by_meaning(part, index, child.meaning[outcome])


def _by_meaning(part: Part, index: int, meaning: str) -> Lead:
    following = part.children[index + 1].name if index + 1 < len(part.children) else None
    match part.node:
        case model.Sequence():
            return Lead(to=following) if meaning == "success" and following is not None else Lead(end=meaning)
        case model.Fallback():
            return Lead(to=following) if meaning == "failure" and following is not None else Lead(end=meaning)
        case model.Loop() | model.ForEach():
            return Lead(to=COUNT) if meaning == "success" else Lead(end="failure")
        case model.Switch() | model.Cooldown():
            return Lead(end=meaning)
        case model.Retry():
            return Lead(to=COUNT) if meaning == "failure" else Lead(end="success")
        case model.Repeat(times=times):
            again = COUNT if times is not None else part.children[0].name
            return Lead(to=again) if meaning == "success" else Lead(end="failure")
        case model.Invert():
            return Lead(end="failure" if meaning == "success" else "success")
        case model.Force(as_=forced):
            return Lead(end=forced)
    raise TypeError(f"{part.path}: {type(part.node).__name__} has no transitions")


def _target(way: Lead, names: dict[str, str]) -> str:
    if way.to is not None:
        return names.get(way.to, way.to)
    assert way.end is not None, "an end leads to a child or out"
    return way.end


def _initial(part: Part) -> str:
    return part.node.initial if isinstance(part.node, model.StateMachine) else part.children[0].name
