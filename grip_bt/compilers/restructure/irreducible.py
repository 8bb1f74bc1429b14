"""Which edges of a state machine keep it from being made of chains and loops.

A flow graph has a structure when each edge that a depth-first search finds to lead back leads to a state that
dominates its tail: then every loop is entered at one state (Hecht and Ullman, 1974).
"""

from __future__ import annotations

from itertools import combinations

import networkx as nx

BUDGET = 500
"""Sets of edges that are tried at most; beyond that, a set that is enough is given, not the smallest."""

Edge = tuple[str, str]


def offending_edges(graph: nx.DiGraph, initial: str) -> tuple[list[Edge], bool]:
    """Return edges without which the graph would have a structure, and whether no smaller set is known to be enough.

    Args:
        graph: which state leads to which.
        initial: the first state, from which all others are reached.
    """
    enough = unruly_edges(graph, initial)
    tried = 0
    for size in range(1, len(enough)):
        for edges in combinations(graph.edges, size):
            tried += 1
            if tried > BUDGET:
                return enough, False
            if not unruly_edges(_without(graph, initial, edges), initial):
                return list(edges), True
    return enough, True


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


def _without(graph: nx.DiGraph, initial: str, edges: tuple[Edge, ...]) -> nx.DiGraph:
    copy = graph.copy()
    copy.remove_edges_from(edges)
    return copy.subgraph({initial, *nx.descendants(copy, initial)})
