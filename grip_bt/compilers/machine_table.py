"""Containers whose children run one after the other, as transitions: where each end of each child leads.

They come from exploring the container's kind: an end after which it asks nothing is a transition, one after which it
asks leads to the state `again?`, which asks. An end that carries a failure code gets a label of its own,
`failure.no_ik`, where an edge here or further out uses it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from grip_bt.task.exploration import UNKNOWN, Labels, Oracle, answered, answers
from grip_bt.task.kinds.base import CHILD, End, Ended, Kind, Next, Run, Step
from grip_bt.task.model import Foreign, Leaf
from grip_bt.task.parts import Edges

from .behaviour_state import Refined
from .resolve import Part

AGAIN = "again?"
"""Label of the state that asks what comes next; no node's name can contain the question mark."""


@dataclass(frozen=True)
class Lead:
    """Where an end leads: to the child `to`, or out by the outcome `end`."""

    to: str | None = None
    end: str | None = None


@dataclass
class Table:
    """Transitions of one container.

    Attributes:
        rows: child -> label of its end -> where it leads; in order.
        refined: child -> (outcome, code) pairs that need a label.
    """

    rows: dict[str, dict[str, str]] = field(default_factory=dict)
    refined: dict[str, set[tuple[str, str]]] = field(default_factory=dict)
    initial: str = ""


def interrupts(part: Part) -> bool:
    """Tell whether the container may interrupt a running child, or has none: no blocking states are equal to it."""
    if isinstance(part.node, Leaf | Foreign):
        return False
    return not part.node.blocking or not part.children


def asks(part: Part) -> bool:
    """Tell whether it asks anything about data, counts or the time to know what comes next."""
    return bool(_asked(part))


def counts(part: Part) -> bool:
    """Tell whether it asks for nothing but whether there were enough attempts, after the first one."""
    return not interrupts(part) and _asked(part) == {"again", "enough"} and first_step(part) is not None


def chooses(part: Part) -> bool:
    """Tell whether it asks who comes next, or whether anybody does."""
    return asks(part) and not counts(part)


def _asked(part: Part) -> frozenset[str]:
    if isinstance(part.node, Leaf | Foreign) or interrupts(part) or part.node.concurrent:
        return frozenset()
    return answers(part.node, part.labels) - {"exit"}


def state_labels(part: Part) -> dict[str, str]:
    """Return child -> label of its state.

    It is the child's name, unless that is an outcome of the container too: in smach a target that names both is the
    state, and only where children's own edges lead does the document mean that.
    """
    if isinstance(part.node, Kind) and part.node.by_edges:
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
        needed: its own (outcome, code) pairs for which its parent needs a label.
    """
    table, names, own = Table(), state_labels(part), own_edges(part)
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
    first = first_step(part)
    table.initial = AGAIN if first is None else names[part.children[first.children[0]].name]
    return table


def first_step(part: Part) -> Run | None:
    """Return who is run first, and in which state of the kind; None where it asks, or has to keep what it counts."""
    kind = kind_of(part)
    step = _only_step(kind, part.labels, lambda q: kind.begin(None, q))
    if type(step) is not Run:
        return None
    return step if step.state is not UNKNOWN or not asks(part) else None  # who never asks keeps nothing


def own_edges(part: Part) -> Edges:
    """Return where ends of the children lead that the document says something of."""
    return part.edges if kind_of(part).by_edges else part.exits


def leads(part: Part, index: int) -> Iterator[tuple[str, str | None, Lead]]:
    """Yield how a child ends (outcome, and code where an edge names it) and where that leads; codes come after all."""
    child, edges = part.children[index], own_edges(part)
    for outcome in child.meaning:
        for code in (None, *sorted(edges.codes(child.name, outcome))):
            yield outcome, code, lead(part, index, outcome, code)


def kind_of(part: Part) -> Kind:
    """Return the kind of a container."""
    assert isinstance(part.node, Kind), "leaves have no transitions"
    return part.node


def lead(part: Part, index: int, outcome: str, code: str | None) -> Lead:
    """Return where the end of the child at `index` leads."""
    labels = part.labels
    kind, child = kind_of(part), part.children[index]
    end = Ended(child.name, outcome, child.meaning[outcome], code)
    taken = labels.exit(end)
    if taken is not None:
        return Lead(end=taken)
    step = _only_step(kind, labels, lambda q: kind.ended(UNKNOWN, index, end, q))
    if type(step) is End and step.reason is CHILD:
        return Lead(end=step.outcome)
    if type(step) is Run and not asks(part):  # else the state in which the kind runs it has to be kept
        return Lead(to=labels.names[step.children[0]])
    return Lead(to=AGAIN)


def _only_step(kind: Kind, labels: Labels, call: Callable[[Oracle], Step]) -> Step | None:
    """Return what follows, `Next` followed to its end; None where the kind asks, or writes."""
    while True:
        ways = list(answered(labels, call))
        if len(ways) != 1 or ways[0][1].asked or ways[0][1].puts:
            return None
        step = ways[0][0]
        if type(step) is not Next:
            return step
        state = step.state

        def call(q: Oracle, state: object = state) -> Step:
            return kind.begin(state, q)


def _target(way: Lead, names: dict[str, str]) -> str:
    if way.to is not None:
        return names.get(way.to, way.to)
    assert way.end is not None, "an end leads to a child or out"
    return way.end
