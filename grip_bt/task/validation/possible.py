"""Which ends of nodes are possible at all, over all paths that a task can take."""

from __future__ import annotations

from grip_bt.task import Leaf
from grip_bt.task.exploration import Labels
from grip_bt.task.kind_analysis import edges_of, possible
from grip_bt.task.model import Childless
from grip_bt.task.validation.analysis import PlacedNode, TaskAnalysis


class PossibleOutcomes:
    """The possible ends of every node, found from the leaves upwards.

    Attributes:
        ends: path of a container -> what its children may end with.
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
        if isinstance(node, Leaf) or (isinstance(node, Childless) and not placed.children):
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
