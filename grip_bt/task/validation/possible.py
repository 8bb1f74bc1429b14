"""With which outcomes nodes can end at all, and which children are ever reached, whatever the leaves do."""

from __future__ import annotations

from collections.abc import Mapping

from grip_bt.task.exploration import Labels
from grip_bt.task.kind_analysis import edges_of, possible
from grip_bt.task.model import Childless

from .analysis import PlacedNode, TaskAnalysis


class PossibleOutcomes:
    """PossibleOutcomes ends of every node, found from the leaves upwards.

    Attributes:
        ends: path of a container -> what its children may end with.
        unreached: nodes that are never run.
    """

    def __init__(self, analysis: TaskAnalysis):
        self._labels: dict[str, frozenset[str]] = {}
        self.ends: dict[str, Labels] = {}
        self.unreached: list[PlacedNode] = []
        for placed in reversed(analysis.nodes):
            labels = self._of(placed)
            self._labels[placed.path] = labels | {"failure"} if placed.node.precondition else labels

    def labels(self, placed: PlacedNode) -> frozenset[str]:
        """Return the outcomes with which a node can end."""
        return self._labels[placed.path]

    def _of(self, placed: PlacedNode) -> frozenset[str]:
        node = placed.node
        if isinstance(node, Childless):
            return frozenset(placed.outcomes)
        ends = {
            # what an exit leads to needn't be there
            name: [(label, child.outcomes[label]) for label in self._labels[child.path] if label in child.outcomes]
            for name, child in placed.children.items()
        }
        labels = self.ends[placed.path] = Labels(ends, *edges_of(node))
        found, reached = possible(node, labels)
        self.unreached.extend(child for name, child in placed.children.items() if name not in reached)
        return frozenset(found & placed.outcomes.keys() if node.by_edges else found)


def machine_edges(placed: PlacedNode, labels: Mapping[str, frozenset[str]]) -> dict[str, list[str]]:
    """Return where each child of a state machine can lead: siblings and outcomes."""
    edges: dict[str, list[str]] = {}
    for name, child in placed.children.items():
        possible = labels[child.path]
        edges[name] = [t for label, t in child.node.on.items() if label.partition(".")[0] in possible]
    return edges


def reachable(start: str, edges: Mapping[str, list[str]]) -> set[str]:
    """Return everything that can be reached from `start`, itself included."""
    seen, stack = {start}, [start]
    while stack:
        for target in edges.get(stack.pop(), ()):
            if target not in seen:
                seen.add(target)
                stack.append(target)
    return seen
