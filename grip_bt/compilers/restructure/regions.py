"""Flow graph of a state machine -> chains and loops, by the reductions T1 and T2 of Hecht and Ullman.

T1 makes a region with an edge to its own entry a loop. T2 joins a region with a single predecessor to that one. Both
are applied in a fixed order, so that one machine always gets one structure: inner loops first (by their natural loops),
and within a loop in reverse post-order, in which the first edge of a state is followed first.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import networkx as nx


@dataclass(frozen=True)
class Arc:
    """One end of a state, and where it leads.

    Attributes:
        code: failure code that the end must have; None for all ends that no other arc of the outcome names.
    """

    state: str
    outcome: str
    code: str | None
    meaning: str
    target: str

    @property
    def label(self) -> str:
        return self.outcome if self.code is None else f"{self.outcome}.{self.code}"

    def __str__(self) -> str:
        return f"{self.state}.{self.label} -> {self.target}"


@dataclass(frozen=True)
class State:
    """One state."""

    entry: str
    leaving: tuple[Arc, ...]

    @property
    def last(self) -> str:
        return self.entry


@dataclass(frozen=True)
class Chain:
    """Regions in order: from each but the last, the arcs to the next one's entry stay inside.

    Attributes:
        goes_on: meaning of the ends that go on to the next part.
    """

    parts: tuple[Region, ...]
    goes_on: str

    @property
    def entry(self) -> str:
        return self.parts[0].entry

    @property
    def last(self) -> str:
        return self.parts[-1].last

    @cached_property
    def leaving(self) -> tuple[Arc, ...]:
        inner = [
            arc
            for part, following in zip(self.parts, self.parts[1:], strict=False)
            for arc in part.leaving
            if arc.target != following.entry
        ]
        return (*inner, *self.parts[-1].leaving)


@dataclass(frozen=True)
class Loop:
    """A region again and again, as long as it ends by an arc to its own entry."""

    body: State | Chain

    @property
    def entry(self) -> str:
        return self.body.entry

    @property
    def last(self) -> str:
        return self.body.last

    @cached_property
    def leaving(self) -> tuple[Arc, ...]:
        return tuple(arc for arc in self.body.leaving if arc.target != self.entry)


Region = State | Chain | Loop


def flow_graph(initial: str, arcs: Mapping[str, Iterable[Arc]]) -> nx.DiGraph:
    """Return which state leads to which, for the states that are reached at all."""
    graph = nx.DiGraph()
    graph.add_nodes_from(arcs)
    for state, leaving in arcs.items():
        # A depth-first search that takes the last arc first finishes the first one last: its states come first
        # in reverse post-order.
        graph.add_edges_from((state, arc.target) for arc in reversed(list(leaving)) if arc.target in arcs)
    return graph.subgraph({initial, *nx.descendants(graph, initial)}).copy()


def structured(initial: str, arcs: Mapping[str, Iterable[Arc]]) -> Region | None:
    """Return the structure of a state machine, given each state's arcs, the most usual first; None when it has none."""
    return _Reduction(initial, arcs).run()


class _Reduction:
    def __init__(self, initial: str, arcs: Mapping[str, Iterable[Arc]]):
        self.initial = initial
        self.graph = flow_graph(initial, arcs)
        self.regions: dict[str, Region] = {state: State(state, tuple(arcs[state])) for state in self.graph}
        self.order = list(reversed(list(nx.dfs_postorder_nodes(self.graph, initial))))
        self.dominator = nx.immediate_dominators(self.graph, initial)

    def run(self) -> Region | None:
        for header in reversed(self.order):
            body = self.natural_loop(header)
            if body:
                self.join(header, body)
                self.close(header)
        self.join(self.initial, set(self.graph))
        return self.regions[self.initial] if len(self.graph) == 1 else None

    def natural_loop(self, header: str) -> set[str]:
        """Return what reaches the edges back to `header` without passing it, itself included; empty without any."""
        stack = [tail for tail in self.graph.predecessors(header) if self.dominates(header, tail)]
        body = {header, *stack} if stack else set()
        while stack:
            state = stack.pop()
            new = set(self.graph.predecessors(state)) - body if state != header else set()
            body |= new
            stack.extend(new)
        return body

    def dominates(self, upper: str, lower: str) -> bool:
        while lower != upper and lower != self.initial:
            lower = self.dominator[lower]
        return lower == upper

    def join(self, header: str, body: set[str]) -> None:
        for state in [s for s in self.order if s in body and s != header]:
            before = list(self.graph.predecessors(state))
            if len(before) == 1 and before[0] in body and before[0] != state:
                self.merge(before[0], state)

    def merge(self, region: str, state: str) -> None:
        self.regions[region] = then(self.regions[region], self.regions.pop(state))
        self.graph.add_edges_from((region, target) for target in list(self.graph.successors(state)))
        self.graph.remove_node(state)

    def close(self, header: str) -> None:
        """Apply T1, unless something of the loop could not be joined to its header."""
        if self.graph.has_edge(header, header):
            region = self.regions[header]
            assert not isinstance(region, Loop), "a natural loop holds all edges back to its header"
            self.regions[header] = Loop(region)
            self.graph.remove_edge(header, header)


def then(first: Region, second: Region) -> Region:
    """Return `first` followed by `second`, as one flat chain where that says the same."""
    head = first.parts if isinstance(first, Chain) else (first,)
    tail = second.parts if isinstance(second, Chain) else (second,)
    skipping = any(arc.target == second.entry for part in head[:-1] for arc in part.leaving)
    if not skipping:
        for front, back in ((head, tail), (head, (second,)), ((first,), tail)):
            fixed = {
                c.goes_on for c, parts in ((first, front), (second, back)) if isinstance(c, Chain) and parts != (c,)
            }
            fitting = [m for m in continuing_meanings(front[-1], second.entry) if fixed <= {m}]
            if fitting:
                return Chain((*front, *back), fitting[0])
    return Chain((first, second), continuing_meanings(first, second.entry)[0])


def depth(region: Region) -> int:
    """Return how many new containers lie within each other where the nesting is deepest."""
    deepest, stack = 0, [(region, 1)]
    while stack:
        inner, level = stack.pop()
        deepest = max(deepest, level)
        below = inner.parts if isinstance(inner, Chain) else (inner.body,) if isinstance(inner, Loop) else ()
        stack.extend((part, level + 1) for part in below if not isinstance(part, State))
    return deepest


def continuing_meanings(region: Region, target: str) -> list[str]:
    """Return the meanings with which the ends of `region` that lead to `target` can go on to it, the best first.

    Ends of one state have the meaning that they have. A region of several states gets a label for `target`, whose
    meaning is free, and so does a state with ends of both meanings, which is wrapped.
    """
    meanings = {arc.meaning for arc in region.leaving if arc.target == target}
    if isinstance(region, State) and len(meanings) == 1:
        return list(meanings)
    return ["failure", "success"] if meanings == {"failure"} else ["success", "failure"]


Edge = tuple[str, str]


def unruly_edges(graph: nx.DiGraph, initial: str) -> list[Edge]:
    """Return the edges that lead back to a state which doesn't dominate their tail; without them, none is left."""
    rank = {state: number for number, state in enumerate(nx.dfs_postorder_nodes(graph, initial))}
    dominator = nx.immediate_dominators(graph, initial)
    result = []
    for tail, head in graph.edges:
        if rank[tail] <= rank[head]:
            above = tail
            while above not in (head, initial):
                above = dominator[above]
            if above != head:
                result.append((tail, head))
    return result
