"""Boxes and lines of a drawing with their places; how they are laid out: as trees, and in layers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

Point = tuple[float, float]
NAME_SIZE, TEXT_SIZE = 13.0, 11.0
_WIDTHS = {  # in em; what a browser's DejaVu Sans, the widest of the usual fonts, gives
    **dict.fromkeys("ijl'|:;.,()[] I/!-", 0.36),
    **dict.fromkeys("frtJ", 0.43),
    **dict.fromkeys("mwMW%@=+<>~", 0.9),
    **dict.fromkeys("ABCDEGHKNOPQRSTUVXYZ", 0.72),
}
_WIDTH, _WIDTH_BEYOND_LATIN = 0.64, 0.95


@dataclass(frozen=True)
class Box:
    """A node from its upper left corner: a leaf, or as a `frame` a container; `title` is shown under the pointer."""

    x: float
    y: float
    width: float
    height: float
    kind: str
    name: str
    lines: tuple[str, ...] = ()
    title: str = ""
    frame: bool = False


@dataclass(frozen=True)
class Pill:
    """An outcome; or, with an empty name, the dot where a state machine starts."""

    x: float
    y: float
    width: float
    height: float
    name: str
    meaning: str


@dataclass(frozen=True)
class Line:
    """A line through points; curved where they are neither beside nor below one another."""

    points: tuple[Point, ...]
    label: str = ""
    label_at: Point = (0.0, 0.0)
    arrow: bool = True


@dataclass
class Figure:
    """Everything that is drawn; later things lie over earlier ones."""

    width: float = 0.0
    height: float = 0.0
    boxes: list[Box] = field(default_factory=list)
    pills: list[Pill] = field(default_factory=list)
    lines: list[Line] = field(default_factory=list)

    def add(self, other: Figure, dx: float, dy: float) -> None:
        """Add another figure, moved by (dx, dy)."""
        self.boxes.extend(replace(b, x=b.x + dx, y=b.y + dy) for b in other.boxes)
        self.pills.extend(replace(p, x=p.x + dx, y=p.y + dy) for p in other.pills)
        self.lines.extend(
            replace(
                line,
                points=tuple((x + dx, y + dy) for x, y in line.points),
                label_at=(line.label_at[0] + dx, line.label_at[1] + dy),
            )
            for line in other.lines
        )


def text_width(text: str, size: float, bold: bool = False) -> float:
    """Return about how wide a text is in a common sans-serif font [px]; rather too wide than too narrow."""
    units = sum(_WIDTHS.get(c, _WIDTH if c < "\u0250" else _WIDTH_BEYOND_LATIN) for c in text)
    return units * size * (1.13 if bold else 1.0)


def shortened(text: str, length: int = 44) -> str:
    """Return a text of at most `length` characters."""
    return text if len(text) <= length else text[: length - 1] + "…"


@dataclass(slots=True)
class TreeItem:
    """A node of the tree to lay out: its box's height [px], its children, and its middle, set by `place_tree`."""

    height: float
    below: list[TreeItem] = field(default_factory=list)
    y: float = 0.0

    @property
    def lead(self) -> float:
        """How far its middle is below the top of all that it holds [px]."""
        return max(self.height / 2, self.below[0].lead) if self.below else self.height / 2


def place_tree(item: TreeItem, gap: float, top: float = 0.0) -> float:
    """Set `y` of an item, beside the first of its children, and of all below; return where they end [px].

    Args:
        gap: least distance of boxes in a column [px].
        top: where they begin [px].
    """
    item.y = top + item.lead
    bottom = item.y - item.below[0].lead - gap if item.below else top
    for child in item.below:
        bottom = place_tree(child, gap, bottom + gap)
    return max(bottom, item.y + item.height / 2)


# Nodes in layers, edges downwards: how the children of one container are placed in the flow view.
#
# Sugiyama, Tagawa & Toda, "Methods for Visual Understanding of Hierarchical System Structures" (1981): edges that
# close cycles are turned round, nodes are ranked by longest paths, edges get a place in each rank that they cross,
# ranks are ordered by barycentres, and places are the least-squares solution that keeps this order (isotonic
# regression). Each edge passes through a rank that belongs to its label, so labels cover nothing.

_SWEEPS = 8


@dataclass(slots=True)
class Item:
    """Something with a place [px]: a node, or where an edge crosses a rank; `x` is its middle."""

    width: float
    height: float
    rank: int = 0
    x: float = 0.0
    up: list[Item] = field(default_factory=list)
    down: list[Item] = field(default_factory=list)


@dataclass(slots=True)
class Edge:
    """A connection between nodes, with the size of its label [px]; `place` sets what it passes, and where that is."""

    source: str
    target: str
    label: tuple[float, float] = (0.0, 0.0)
    bends: list[Item] = field(default_factory=list)
    label_item: Item | None = None


@dataclass(frozen=True)
class Placed:
    """How large the whole is, and the upper edge and height of each rank [px]."""

    width: float
    height: float
    tops: tuple[float, ...]
    heights: tuple[float, ...]


def place(nodes: dict[str, Item], edges: Sequence[Edge], last: Sequence[str], gap: float, rank_gap: float) -> Placed:
    """Place nodes and edges.

    Args:
        nodes: by name, in document order; their `rank` and `x` are set.
        edges: between different nodes; their `bends` are set.
        last: names of nodes that stand in the last rank.
        gap: least distance in a rank [px].
        rank_gap: distance of ranks [px].
    """
    backward = _ranked(nodes, edges, last)
    ranks: list[list[Item]] = [[] for _ in range(max(n.rank for n in nodes.values()) + 1)]
    for node in nodes.values():
        ranks[node.rank].append(node)
    for edge in edges:
        _route(nodes, edge, (edge.source, edge.target) in backward, ranks)
    _order(ranks)
    _spread(ranks, gap)
    heights = tuple(max((i.height for i in rank), default=0.0) for rank in ranks)
    tops, y = [], 0.0
    for height in heights:
        tops.append(y)
        y += height + rank_gap
    every = [item for rank in ranks for item in rank]
    left = min(i.x - i.width / 2 for i in every)
    for item in every:
        item.x -= left
    width = max(i.x + i.width / 2 for i in every)
    return Placed(width, y - rank_gap, tuple(tops), heights)


def _ranked(nodes: dict[str, Item], edges: Sequence[Edge], last: Sequence[str]) -> set[tuple[str, str]]:
    """Rank the nodes; return the edges that close a cycle when they are followed depth first in document order."""
    import networkx as nx

    graph: nx.DiGraph[str] = nx.DiGraph()
    graph.add_nodes_from(nodes)
    graph.add_edges_from((edge.source, edge.target) for edge in edges)
    around, backward = set[str](), set[tuple[str, str]]()
    for source, target, way in nx.dfs_labeled_edges(graph):
        if way == "nontree" and target in around:
            backward.add((source, target))
        elif way != "nontree":
            (around.add if way == "forward" else around.discard)(target)
    graph.remove_edges_from(backward)
    graph.add_edges_from((target, source) for source, target in backward)
    for rank, names in enumerate(nx.topological_generations(graph)):
        for name in names:
            nodes[name].rank = 2 * rank
    deepest = max(node.rank for node in nodes.values())
    for name in last:
        nodes[name].rank = deepest
    return backward


def _route(nodes: dict[str, Item], edge: Edge, backward: bool, ranks: list[list[Item]]) -> None:
    upper, lower = nodes[edge.source], nodes[edge.target]
    if backward:
        upper, lower = lower, upper
    if upper.rank == lower.rank:  # between two nodes of the last rank
        return
    chain = [Item(0.0, 0.0, rank) for rank in range(upper.rank + 1, lower.rank)]
    edge.label_item = chain[-1] if backward else chain[0]
    edge.label_item.width, edge.label_item.height = edge.label
    for item in chain:
        ranks[item.rank].append(item)
    whole = [upper, *chain, lower]
    for one, other in zip(whole, whole[1:], strict=False):
        one.down.append(other)
        other.up.append(one)
    edge.bends = chain[::-1] if backward else chain


def _order(ranks: list[list[Item]]) -> None:
    for sweep in range(_SWEEPS):
        downwards = sweep % 2 == 0
        for rank, fixed in (
            zip(ranks[1:], ranks, strict=False) if downwards else zip(ranks[-2::-1], ranks[::-1], strict=False)
        ):
            at = {id(item): position for position, item in enumerate(fixed)}
            mine = {id(item): position for position, item in enumerate(rank)}
            keys = {}
            for item in rank:
                near = [at[id(n)] for n in (item.up if downwards else item.down)]
                scale = len(fixed) / max(len(rank), 1)
                keys[id(item)] = sum(near) / len(near) if near else mine[id(item)] * scale
            rank.sort(key=lambda item: (keys[id(item)], mine[id(item)]))


def _spread(ranks: list[list[Item]], gap: float) -> None:
    for rank in ranks:
        x = 0.0
        for item in rank:
            item.x = x + item.width / 2
            x += item.width + gap
    for sweep in range(2 * _SWEEPS):
        downwards = sweep % 2 == 0
        for rank in ranks if downwards else ranks[::-1]:
            wanted = []
            for item in rank:
                near = (item.up if downwards else item.down) or (item.down if downwards else item.up)
                wanted.append(sum(n.x for n in near) / len(near) if near else item.x)
            for item, x in zip(rank, _separated(rank, wanted, gap), strict=True):
                item.x = x


def _separated(rank: list[Item], wanted: list[float], gap: float) -> list[float]:
    """Return the places nearest to `wanted` (least squares) that keep the order and the distances."""
    offsets, offset = [], 0.0
    for left, right in zip([None, *rank], rank, strict=False):
        if left is not None:
            offset += (left.width + right.width) / 2 + gap
        offsets.append(offset)
    blocks: list[tuple[float, int]] = []  # mean and length of what is pushed together: pool adjacent violators
    for want, off in zip(wanted, offsets, strict=True):
        mean, length = want - off, 1
        while blocks and blocks[-1][0] >= mean:
            before, many = blocks.pop()
            mean, length = (before * many + mean * length) / (many + length), many + length
        blocks.append((mean, length))
    flat = [mean for mean, length in blocks for _ in range(length)]
    return [mean + off for mean, off in zip(flat, offsets, strict=True)]
