"""What is known of a container from all its ways: with what it may end, what is written then, what is drawn."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from typing import Literal

from .exploration import START, UNKNOWN, Labels, Oracle, TooManyError, Way, answered, explore, graph
from .kinds.base import End, Ended, Kind, Next, Run, Step
from .parts import Edges, Meaning

TimeSense = Literal["before", "after"]
_PLAIN = frozenset({"true", "false", "after", "before", "next", "none", "again", "enough"})
"""Answers that don't say which child is run."""
_MEANINGS: tuple[Meaning, ...] = ("success", "failure")


def edges_of(kind: Kind) -> tuple[Edges, Edges]:
    """Return where a container's exits lead, and its children's own edges."""
    return Edges.of_exits(kind.exits), Edges.of_children({name: child.on for name, child in kind.below.items()})


def time_sense(kind: Kind, labels: Labels) -> TimeSense | None:
    """Return which answer about the time lets the children run: `before` a limit, or `after` a rest.

    None: it doesn't ask, or they run either way.
    """
    if kind.concurrent or not kind.explorable(labels.all):
        return None
    runs: set[str] = set()
    ends: set[str] = set()
    for way in graph(kind, labels):
        (ends if type(way.step) is End else runs).update({"before", "after"}.intersection(way.answers))
    if len(runs) == 1 and runs.isdisjoint(ends):
        return "before" if "before" in runs else "after"
    return None


def possible(kind: Kind, labels: Labels) -> tuple[set[str], set[str]]:
    """Return the outcomes with which a container may end, and the children that may be run."""
    if not kind.explorable(labels.all):
        outcomes, run = kind.possible(labels.all)
        return outcomes, set(labels.names[:run])
    found: set[str] = set()
    reached: set[str] = set()
    try:
        for way in graph(kind, labels):
            if type(way.step) is End:
                found.add(way.step.outcome)
            if way.to is not None:
                reached.update(labels.names[i] for i in way.to[1])
    except TooManyError:
        return set(kind.all_outcomes()), set(labels.names)
    return found, reached


def flow(
    kind: Kind,
    labels: Labels,
    state: int,
    after: Callable[[str, int], Mapping[str, int]],
    bit_of: Callable[[str], int],
    read: Callable[[str, int], None],
) -> dict[str, int]:
    """Return outcome -> the variables that are surely written when a container ends with it, as a set of bits.

    Args:
        state: what is written on entry.
        after: child, what is written before -> outcome -> what is written after.
        bit_of: a key that the kind puts into -> the variable's bit.
        read: called with a key, and what is written when it is read.
    """
    if not kind.explorable(labels.all):
        return kind.flow(labels.all, lambda child, before: after(labels.names[child], before), state)
    ways: dict[object, list[Way]] = {}
    for way in graph(kind, labels):
        ways.setdefault(way.at, []).append(way)
    found: dict[str, int] = {}
    before: dict[object, int] = {START: state}
    todo: deque[object] = deque([START])
    while todo:
        at = todo.popleft()
        here = before[at]
        for way in ways.get(at, ()):
            for key in way.reads:
                read(key, here)
            there = here
            for key in way.puts:
                there |= bit_of(key)
            if way.child is not None and way.end is not None:
                # of children that run together, none may rely on what another writes
                ends = after(labels.names[way.child], state if kind.concurrent else here)
                if way.end.outcome not in ends:
                    continue
                there |= ends[way.end.outcome]
            if type(way.step) is End:
                found[way.step.outcome] = found.get(way.step.outcome, there) & there
            elif way.to is not None:
                for index in way.to[1]:  # also those that never end read something
                    after(labels.names[index], state if kind.concurrent else there)
                old = before.get(way.to)
                new = there if old is None else old & there
                if new != old:
                    before[way.to] = new
                    todo.append(way.to)
    return found


def following(kind: Kind, names: list[str], child: str, meaning: str) -> str:
    """Return which child or outcome comes after an end that leads nowhere by its label; the end where that depends."""
    labels = Labels({name: [("success", "success"), ("failure", "failure")] for name in names}, Edges(), Edges())
    end = Ended(child, meaning, meaning)
    steps = [step for step, _ in answered(labels, lambda q: kind.ended(UNKNOWN, names.index(child), end, q))]
    if len(steps) == 1 and type(steps[0]) is Run:
        return names[steps[0].children[0]]
    return steps[0].outcome if len(steps) == 1 and type(steps[0]) is End else meaning


def surely_first(kind: Kind) -> str:
    """Return the child with which a container begins, whatever its questions are answered; empty where that depends."""
    labels = _plain(kind)
    if not labels.names:
        return ""
    steps = [step for step, _ in answered(labels, lambda q: kind.begin(None, q))]
    alone = [step.children[0] for step in steps if type(step) is Run and len(step.children) == 1]
    return labels.names[alone[0]] if steps and len(set(alone)) == 1 and len(alone) == len(steps) else ""


def derived_edges(kind: Kind) -> dict[str, dict[Meaning, tuple[str, bool]]]:
    """Return where an end of a child leads by itself, where it doesn't end the container with its own meaning.

    Returns:
        Child -> the meaning of its end -> a child that may run then, or an outcome; whether it is an outcome. Nothing
        where children run at the same time, or say themselves where they lead.
    """
    if kind.by_edges or kind.concurrent:
        return {}
    labels = _plain(kind)
    found: dict[str, dict[Meaning, tuple[str, bool]]] = {}
    for child, name in enumerate(labels.names):
        for meaning in _MEANINGS:
            end = Ended(name, meaning, meaning)

            def after(q: Oracle, child: int = child, end: Ended = end) -> Step:
                step = kind.ended(UNKNOWN, child, end, q)
                return kind.begin(step.state, q) if type(step) is Next else step

            steps = [step for step, _ in answered(labels, after)]
            runs = [labels.names[step.children[0]] for step in steps if type(step) is Run]
            ends = [step.outcome for step in steps if type(step) is End]
            if runs:
                found.setdefault(name, {})[meaning] = (runs[0], False)
            elif ends and ends[0] != meaning:
                found.setdefault(name, {})[meaning] = (ends[0], True)
    return found


Drawn = dict[tuple[str, str, bool], list[str]]
"""(child or empty, child or outcome, whether it is an outcome) -> labels."""


def links(kind: Kind) -> Drawn:
    """Return what is drawn among a container's children.

    Where labels lead is data of the document and drawn as it stands, reachable or not, except to what isn't there;
    order and choice are explored. A start is drawn where there is a choice, or labels decide.
    """
    exits, edges = edges_of(kind)
    names = kind.below.keys()
    found: Drawn = {}
    if kind.by_edges:
        for name in _starts(kind):
            found["", name, False] = []
        for (child, outcome, code), target in edges:
            if target in names or target in kind.outcomes:
                found.setdefault((child, target, target not in names), []).append(_label(outcome, code))
        return found
    if not kind.late_exits:
        found = _order(kind)
    for (child, outcome, code), target in exits:
        if child in names:
            found.setdefault((child, target, True), []).append(_label(outcome, code))
    return found


def _label(outcome: str, code: str | None) -> str:
    return outcome if code is None else f"{outcome}.{code}"


def _plain(kind: Kind) -> Labels:
    return Labels({name: [(meaning, meaning) for meaning in _MEANINGS] for name in kind.below}, Edges(), Edges())


def _starts(kind: Kind) -> dict[str, list[str]]:
    starts: dict[str, list[str]] = {}
    for way in explore(kind, _plain(kind)):
        if way.at != START:
            break  # the ways from the start come first
        if type(way.step) is Run:
            starts.setdefault(list(kind.below)[way.step.children[0]], []).extend(way.answers)
    return starts


def _order(kind: Kind) -> Drawn:
    """Return who follows whom, and who is chosen; a child that is run again isn't drawn."""
    names, found = list(kind.below), Drawn()
    if not names:  # of a subtask: its child stands in another file
        return found
    starts = _starts(kind)
    if len(starts) > 1 or any(answer not in _PLAIN for said in starts.values() for answer in said):
        found = {("", target, False): said for target, said in starts.items()}
    for way in explore(kind, _plain(kind)):
        if type(way.step) is Run and way.child is not None and way.end is not None:
            source, target = names[way.child], names[way.step.children[0]]
            if source != target:
                found[source, target, False] = ["else"] if way.end.meaning == "failure" else []
    return found
