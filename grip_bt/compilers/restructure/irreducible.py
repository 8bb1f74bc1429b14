"""Which edges of a state machine keep it from being made of chains and loops."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import networkx as nx

BUDGET = 3000
"""Sets of edges that are tried at most; beyond that, a set that is enough is given, not the smallest."""

Edge = tuple[str, str]


def offending_edges(graph: nx.DiGraph, initial: str) -> tuple[list[Edge], bool]:
    """Return edges without which the graph would have structure, and whether no smaller set is enough.

    Args:
        graph: which state leads to which.
        initial: the first state, from which all others are reached.
    """
    enough = [edge for edge in _retreating(graph, initial) if not _dominates(graph, initial, edge[1], edge[0])]
    tried = 0
    for size in range(1, len(enough)):
        for edges in combinations(_in_cycles(graph), size):
            tried += 1
            if tried > BUDGET:
                return enough, False
            if reducible(_without(graph, initial, edges), initial):
                return list(edges), True
    return enough, True


def reducible(graph: nx.DiGraph, initial: str) -> bool:
    """Tell whether every cycle is entered through one state that dominates the rest: no cycle without its back edges.

    That is the same as being reduced to one node by T1 and T2 (Hecht and Ullman, 1974).
    """
    back = [edge for edge in graph.edges if _dominates(graph, initial, edge[1], edge[0])]
    forward = graph.copy()
    forward.remove_edges_from(back)
    return bool(nx.is_directed_acyclic_graph(forward))


def _retreating(graph: nx.DiGraph, initial: str) -> Iterator[Edge]:
    """Yield the edges that lead to a state which a depth-first search hasn't left; without them no cycle is left."""
    rank = {state: number for number, state in enumerate(nx.dfs_postorder_nodes(graph, initial))}
    return ((tail, head) for tail, head in graph.edges if rank[tail] <= rank[head])


def _in_cycles(graph: nx.DiGraph) -> list[Edge]:
    cycle = {
        state: number
        for number, part in enumerate(nx.strongly_connected_components(graph))
        for state in part
        if len(part) > 1
    }
    return [(tail, head) for tail, head in graph.edges if head in cycle]


def _without(graph: nx.DiGraph, initial: str, edges: tuple[Edge, ...]) -> nx.DiGraph:
    copy = graph.copy()
    copy.remove_edges_from(edges)
    return copy.subgraph({initial, *nx.descendants(copy, initial)})


def _dominates(graph: nx.DiGraph, initial: str, upper: str, lower: str) -> bool:
    """Tell whether every way from `initial` to `lower` passes `upper`."""
    if upper in (initial, lower):
        return True
    rest = nx.restricted_view(graph, [upper], [])
    return lower not in nx.descendants(rest, initial)
