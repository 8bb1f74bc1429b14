"""What is never reached, and what never ends."""

from __future__ import annotations

from grip_bt.task import StateMachine

from ..possible import Possible, machine_edges, reachable
from ..survey import Spot, Survey


def check_reach(survey: Survey, possible: Possible) -> None:
    """Find children that nothing leads to, state machines that can't end, and children from which no end is reached."""
    for spot in possible.unreached:
        assert spot.parent is not None
        how = (
            "no `on` leads to it"
            if isinstance(spot.parent.node, StateMachine)
            else "the children before it never let it have its turn"
        )
        survey.add(spot.path, None, "unreachable-node", f"it is never reached: {how}", "lead to it, or remove it")
    for spot in survey.containers:
        if isinstance(spot.node, StateMachine) and spot.node.initial in spot.children:
            _ends(survey, spot, spot.node, possible)


def _ends(survey: Survey, spot: Spot, node: StateMachine, possible: Possible) -> None:
    edges = machine_edges(spot, {c.path: possible.labels(c) for c in spot.children.values()})
    back: dict[str, list[str]] = {}
    for source, targets in edges.items():
        for target in targets:
            back.setdefault(target, []).append(source)
    ending = {name for outcome in node.outcomes for name in reachable(outcome, back)}
    if node.initial not in ending:
        survey.add(
            spot.path,
            "outcomes",
            "endless-machine",
            "it can't end: no path from `initial` leads to one of its outcomes",
            "let `on` of a child lead to an outcome",
        )
        return
    reached = reachable(node.initial, edges)
    for name, child in spot.children.items():
        if name in reached and name not in ending and edges[name]:
            survey.add(
                child.path,
                "on",
                "dead-end",
                f"once it is reached, {spot.path} can't end any more",
                "let a path from here lead to an outcome",
            )
