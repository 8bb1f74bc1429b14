"""The graph work: reductions against the criterion of dominators, and the edges that keep them from an end."""

from __future__ import annotations

from random import Random

import networkx as nx

from grip_bt.compilers.restructure.regions import (
    Arc,
    Chain,
    Loop,
    Region,
    State,
    flow_graph,
    structured,
    unruly_edges,
)


def random_arcs(seed: int) -> dict[str, list[Arc]]:
    random = Random(seed)
    names = [f"s{i}" for i in range(random.randint(2, 7))]
    arcs = {
        name: [Arc(name, o, None, "success", random.choice(names)) for o in "abc"[: random.randint(1, 3)]]
        for name in names
    }
    return {name: arcs[name] for name in flow_graph("s0", arcs)}


def states(region: Region) -> list[str]:
    if isinstance(region, State):
        return [region.entry]
    parts = region.parts if isinstance(region, Chain) else (region.body,)
    return [state for part in parts for state in states(part)]


def without(graph: nx.DiGraph, edges: tuple[tuple[str, str], ...]) -> nx.DiGraph:
    rest = graph.copy()
    rest.remove_edges_from(edges)
    return rest.subgraph({"s0", *nx.descendants(rest, "s0")})


def test_the_reductions_end_in_one_region_exactly_where_each_loop_has_one_way_in() -> None:
    reduced = 0
    for seed in range(1500):
        arcs = random_arcs(seed)
        found = structured("s0", arcs)
        whole = found is not None
        assert whole == (not unruly_edges(flow_graph("s0", arcs), "s0")), seed
        reduced += whole
    assert 300 < reduced < 1450


def test_a_region_holds_each_state_once_and_lets_no_arc_to_a_state_out() -> None:
    for seed in range(500):
        arcs = random_arcs(seed)
        found = structured("s0", arcs)
        if found is not None:
            assert sorted(states(found)) == sorted(arcs)
            assert found.entry == "s0"
            assert not found.leaving  # all targets of these arcs are states


def test_a_loop_holds_what_leads_back_and_no_more() -> None:
    arcs = {
        "a": [Arc("a", "success", None, "success", "b"), Arc("a", "failure", None, "failure", "c")],
        "b": [Arc("b", "success", None, "success", "a")],
        "c": [Arc("c", "success", None, "success", "out")],
    }
    found = structured("a", arcs)
    assert isinstance(found, Chain)
    loop, after = found.parts
    assert isinstance(loop, Loop)
    assert states(loop) == ["a", "b"]
    assert states(after) == ["c"]


def test_the_unruly_edges_are_enough() -> None:
    checked = 0
    for seed in range(600):
        graph = flow_graph("s0", random_arcs(seed))
        if not unruly_edges(graph, "s0"):
            continue
        assert not unruly_edges(without(graph, tuple(unruly_edges(graph, "s0"))), "s0")
        checked += 1
    assert checked > 60
