"""Conversions of whole tasks: sequences and fallbacks to state machines, machines with a structure to composites."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from grip_bt.base.errors import listing
from grip_bt.base.frozen import FrozenDict
from grip_bt.compilers.machine_table import interrupts, leads
from grip_bt.compilers.resolve import Part, resolve
from grip_bt.compilers.restructure.composites import PLAIN, Composer
from grip_bt.compilers.restructure.regions import (
    Arc,
    Chain,
    Loop,
    Region,
    State,
    depth,
    flow_graph,
    structured,
    unruly_edges,
)
from grip_bt.compilers.restructure.result import (
    Built,
    Note,
    Restructured,
    common,
    is_within,
    kept,
    paths_of,
    successors,
)
from grip_bt.task.catalog import Catalog
from grip_bt.task.model import Fallback, Leaf, Parallel, Sequence, StateMachine, Subtask, Task, outcomes_of


def to_state_machines(task: Task, catalog: Catalog, within: str = "/") -> Restructured:
    """Return the task with every sequence and fallback that has an equal state machine as that machine.

    Paths stay as they are. Outcomes stay too: a machine declares `success` and `failure`, which its composite had
    without saying so.

    Args:
        within: only this node and those in it are converted.

    Raises:
        InvalidTaskError: the task is wrong; it holds everything that was found.
    """
    work = _ToStates(within)
    root = work.convert(resolve(task, catalog).root, None)
    return Restructured(task.model_copy(update={"root": root.node}), paths_of(root), tuple(work.notes))


class _ToStates:
    def __init__(self, within: str) -> None:
        self.within = within
        self.notes: list[Note] = []

    def convert(self, part: Part, ticker: Part | None) -> Built:
        """Return a node in its new form; `ticker` is the container above that may interrupt it, if there is one."""
        if isinstance(part.node, Leaf | Subtask):
            return Built(part.node, {part.path: ()})
        if not is_within(part.path, self.within):
            inner = part if interrupts(part) else ticker
            return kept(part, {child.name: self.convert(child, inner) for child in part.children})
        ordered = isinstance(part.node, Sequence | Fallback)
        reason = _why_not(part, ticker) if ordered else _by_kind(part)
        if reason:
            self.notes.append(Note(part.path, part.node.kind, reason, by_design=not ordered))
        inner = part if interrupts(part) else ticker
        same = kept(part, {child.name: self.convert(child, inner) for child in part.children})
        return same if reason is not None or not ordered else Built(_machine(part, same), same.places)


def _by_kind(part: Part) -> str | None:
    if isinstance(part.node, StateMachine):
        return None
    if isinstance(part.node, Parallel):
        return "its children run at once, and a state machine has one active child"
    if hasattr(part.node, "child"):
        return "a decorator is about the child that it holds, not about an order"
    return "which child runs is computed, and an edge of a state machine only looks at how a child has ended"


def _why_not(part: Part, ticker: Part | None) -> str | None:
    if not part.children:
        return "it has no children, and a state machine needs a first one"
    if not getattr(part.node, "memory", True):
        return "it is reactive: it asks its first child again while a later one runs"
    if ticker is not None and successors(part):
        return ticked_by(ticker)
    ambiguous = {child.name for child in part.children} & set(part.meaning)
    led_to = {target for row in _rows(part).values() for target in row.values()}
    if ambiguous & led_to:
        names = listing(repr(name) for name in sorted(ambiguous & led_to))
        return f"an edge to {names} could mean a child as well as an outcome; rename the child"
    return None


def ticked_by(ticker: Part) -> str:
    """Return why the inside of a container that looks at every tick keeps its form."""
    assert not isinstance(ticker.node, Leaf), "leaves interrupt nothing"
    return (
        f"it runs in {ticker.path} ({ticker.node.kind}), which may interrupt it at any tick, and a state machine takes"
        " one transition a tick where a composite continues at once"
    )


def _rows(part: Part) -> dict[str, dict[str, str]]:
    rows = {}
    for index, child in enumerate(part.children):
        outcomes = list(child.meaning)
        arcs = sorted(_arcs(part, index), key=lambda arc: (outcomes.index(arc.outcome), arc.code is None))
        rows[child.name] = {arc.label: arc.target for arc in arcs}
    return rows


def _machine(part: Part, same: Built) -> StateMachine:
    node = same.node
    assert isinstance(node, Sequence | Fallback), "only these have an order"
    children = {}
    for name, row in _rows(part).items():
        children[name] = node.children[name].model_copy(update={"on": FrozenDict(row)})
    return StateMachine(
        **common(node),
        kind=StateMachine.kind_name(),
        outcomes=FrozenDict(part.meaning),
        initial=part.children[0].name,
        children=FrozenDict(children),
    )


MAX_DEPTH = 16
"""Containers within each other that one machine may become; a file can't hold many more either."""


def to_trees(task: Task, catalog: Catalog, within: str = "/") -> Restructured:
    """Return the task with every state machine that has a structure as sequences, fallbacks and repeats.

    A machine's place is taken by a composite with its outcomes; states may move into containers that are new. Method:
    T1 and T2 of Hecht and Ullman, with labels as the multi-level exits that make them enough without a variable (Kozen
    and Tseng, MPC 2008).

    Args:
        within: only this node and those in it are converted.

    Raises:
        InvalidTaskError: the task is wrong; it holds everything that was found.
    """
    work = _ToComposites(within)
    resolved = resolve(task, catalog)
    root = work.convert(resolved.root, None)
    ends = {outcome: target for (_, outcome, code), target in resolved.ends if code is None}
    added = {k: v for k, v in _new_ends(resolved.root, root, ends).items() if k not in task.outcomes}
    node = root.node.model_copy(update={"on": FrozenDict({**root.node.on, **added})}) if added else root.node
    return Restructured(task.model_copy(update={"root": node}), paths_of(root), tuple(work.notes))


class _ToComposites:
    def __init__(self, within: str) -> None:
        self.within = within
        self.notes: list[Note] = []

    def convert(self, part: Part, ticker: Part | None) -> Built:
        """Return a node in its new form; `ticker` is the container above that may interrupt it, if there is one."""
        if isinstance(part.node, Leaf | Subtask):
            return Built(part.node, {part.path: ()})
        machine = isinstance(part.node, StateMachine)
        found = _structure(part, ticker) if machine and is_within(part.path, self.within) else None
        if isinstance(found, _Stays):
            self.notes.append(Note(part.path, part.node.kind, found.reason, edges=found.edges))
        inner = part if interrupts(part) else ticker
        children = {child.name: self.convert(child, inner) for child in part.children}
        if isinstance(found, State | Chain | Loop):
            return Composer(part, children).build(found)
        return kept(part, _led_on(part, children) if machine else children)


def _led_on(part: Part, children: dict[str, Built]) -> dict[str, Built]:
    """Give the children of a machine that stays an edge for each outcome that they have got."""
    result = {}
    for child in part.children:
        built = children[child.name]
        on = dict(child.node.on)
        added = _new_ends(child, built, on)
        if added:
            node = built.node.model_copy(update={"on": FrozenDict({**on, **added})})
            built = Built(node, built.places)
        result[child.name] = built
    return result


def _new_ends(part: Part, built: Built, on: Mapping[str, str]) -> dict[str, str]:
    """Return an edge for each outcome that a node has only in its new form.

    A composite has `success` and `failure` even where nothing leads to them, and every outcome needs an edge: it goes
    where another outcome of that meaning goes, and is never taken.
    """
    if isinstance(built.node, Leaf | Subtask):
        return {}
    result = {}
    for outcome, meaning in outcomes_of(built.node).items():
        if outcome not in part.meaning:
            alike = next((o for o, m in part.meaning.items() if m == meaning), next(iter(part.meaning)))
            result[outcome] = on[alike]
    return result


@dataclass(frozen=True)
class _Stays:
    """Why a machine stays one.

    Attributes:
        edges: those without which it would have a structure.
    """

    reason: str
    edges: tuple[str, ...] = ()


def _structure(part: Part, ticker: Part | None) -> Region | _Stays:
    """Return the chains and loops of a machine, or why it stays."""
    odd = [name for name, meaning in part.meaning.items() if PLAIN.get(name, meaning) != meaning]
    if odd:
        return _Stays(f"its outcome {odd[0]!r} means {part.meaning[odd[0]]}, which no composite's can")
    if ticker is not None and successors(part):
        return _Stays(ticked_by(ticker))
    assert isinstance(part.node, StateMachine), "only state machines were requested"
    arcs = {child.name: _arcs(part, index) for index, child in enumerate(part.children)}
    graph = flow_graph(part.node.initial, arcs)
    never = [name for name in arcs if name not in graph]
    if never:
        return _Stays(f"states that are never reached have no place in a composite: {listing(never)}")
    found = structured(part.node.initial, arcs)
    if found is None:
        back = unruly_edges(graph, part.node.initial)
        labels = tuple(str(arc) for tail, head in back for arc in arcs[tail] if arc.target == head)
        return _Stays(
            f"a loop of it is entered at more than one state; without {listing(labels)} none would be", labels
        )
    levels = depth(found)
    if levels > MAX_DEPTH:
        return _Stays(f"its structure has {levels} levels, which is unreadable (at most {MAX_DEPTH} are made)")
    return found


def _arcs(part: Part, index: int) -> list[Arc]:
    """Return how a child ends and where that leads; the codes of an outcome come after it."""
    child = part.children[index]
    return [
        Arc(child.name, outcome, code, child.meaning[outcome], str(way.to or way.end))
        for outcome, code, way in leads(part, index)
    ]
