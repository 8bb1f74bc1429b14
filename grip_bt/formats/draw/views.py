"""The two views of a task: a tree of boxes, and containers as frames with the links inside."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

from grip_bt.formats.draw import layout
from grip_bt.task import KINDS, AnyNode, Container, Leaf, Task, children_of, outcomes_of, walk
from grip_bt.task.catalog import Catalog
from grip_bt.task.kind_analysis import links
from grip_bt.task.model import kind_of

View = Literal["tree", "flow"]
GLYPHS = {"leaf": "", **{name: kind.sign for name, kind in KINDS.items()}}
"""A sign per kind, for text; pictures draw theirs."""


@dataclass(frozen=True)
class Link:
    """A connection between two children, or from a child to an outcome of their container.

    Without a source it is the start of a state machine or a switch; without a label, order alone decides.
    """

    source: str
    target: str
    label: str
    to_outcome: bool = False


def describe(node: AnyNode) -> str:
    """Return what a node is, in a few words."""
    return node.node if isinstance(node, Leaf) else node.words()


def details(node: AnyNode) -> list[str]:
    """Return further lines about a node: literals, and where its ends lead."""
    lines = [f"only if {node.precondition}"] if node.precondition else []
    if isinstance(node, Leaf) and node.with_:
        lines.append(", ".join(f"{name}={value}" for name, value in node.with_.items()))
    lines.extend(f"{label} → {target}" for label, target in node.on.items())
    if not isinstance(node, Leaf):
        lines.extend(node.lines())
        lines.extend(f"{end} ⇥ {target}" for end, target in node.exits.items())
    return lines


def links_of(node: Container) -> list[Link]:
    """Return the links among a container's children, those to what isn't there left out; the same ends are joined."""
    return [Link(s, t, ", ".join(labels), out) for (s, t, out), labels in links(node).items()]


def outcomes_shown(node: Container) -> dict[str, str]:
    """Return the outcomes that are drawn in a container, with their meanings: those that links lead to."""
    meanings: Mapping[str, str] = outcomes_of(node)
    declared = list(node.outcomes)
    used = [link.target for link in links_of(node) if link.to_outcome]
    return {name: meanings.get(name, "failure") for name in dict.fromkeys([*declared, *used])}


_PAD, _COLUMN_GAP, _ROW_GAP, _MARGIN = 10.0, 44.0, 12.0, 20.0
LINE_HEIGHT = 15.0
ICON = 20.0


def box_of(name: str, node: AnyNode, catalog: Catalog, lines: list[str]) -> layout.Box:
    """Return a node's box at the origin, as large as its words need."""
    shown = tuple(layout.shortened(line) for line in lines)
    kind = kind_of(node)
    icon = 0.0 if kind == "leaf" else ICON
    width = icon + layout.text_width(layout.shortened(name), layout.NAME_SIZE, bold=True)
    width = max([width, 70.0, *(layout.text_width(line, layout.TEXT_SIZE) for line in shown)])
    title = node.doc
    if not title and isinstance(node, Leaf) and node.node in catalog:
        title = catalog.get(node.node).doc
    height = 2 * _PAD + layout.NAME_SIZE + len(shown) * LINE_HEIGHT
    return layout.Box(0, 0, width + 2 * _PAD, height, kind, layout.shortened(name), shown, title)


def tree_figure(task: Task, catalog: Catalog) -> layout.Figure:
    """Lay out a task as a tree."""
    boxes: dict[str, layout.Box] = {}
    items: dict[str, layout.TreeItem] = {}
    columns: defaultdict[int, float] = defaultdict(float)
    depth: dict[str, int] = {}
    for path, node in walk(task.root):
        name = task.name if path == "/" else path.rpartition("/")[2]
        box = box_of(name, node, catalog, [describe(node), *details(node)])
        boxes[path], items[path] = box, layout.TreeItem(box.height)
        depth[path] = 0
        if path != "/":
            items[_parent(path)].below.append(items[path])
            depth[path] = depth[_parent(path)] + 1
        columns[depth[path]] = max(columns[depth[path]], box.width)
    height = layout.place_tree(items["/"], _ROW_GAP, _MARGIN) + _MARGIN
    left = [_MARGIN]
    for column in range(len(columns)):
        left.append(left[-1] + columns[column] + _COLUMN_GAP)
    figure = layout.Figure(left[-1] - _COLUMN_GAP + _MARGIN, height)
    for path, box in boxes.items():
        x, y = left[depth[path]], items[path].y
        figure.boxes.append(replace(box, x=x, y=y - box.height / 2))
        if path != "/":
            parent = _parent(path)
            start, from_y = left[depth[path] - 1] + boxes[parent].width, items[parent].y
            trunk = x - _COLUMN_GAP / 2
            figure.lines.append(layout.Line(((start, from_y), (trunk, from_y), (trunk, y), (x, y)), arrow=False))
    return figure


def _parent(path: str) -> str:
    return path.rpartition("/")[0] or "/"


_FRAME_PAD, _HEADER, _GAP, _RANK_GAP, _FLOW_MARGIN = 14.0, 30.0, 22.0, 13.0, 20.0
_PILL_HEIGHT, _START, _LABEL_HEIGHT, _LOOP = 22.0, 12.0, 15.0, 26.0
_PORT_GAP = 16.0


def flow_figure(task: Task, catalog: Catalog) -> layout.Figure:
    """Lay out a task as nested flow charts."""
    inner = _node_figure(task.name, task.root, catalog)
    figure = layout.Figure(inner.width + 2 * _FLOW_MARGIN, inner.height + 2 * _FLOW_MARGIN)
    figure.add(inner, _FLOW_MARGIN, _FLOW_MARGIN)
    return figure


def _node_figure(name: str, node: AnyNode, catalog: Catalog) -> layout.Figure:
    if isinstance(node, Leaf):
        said = details(node)[: bool(node.precondition) + bool(node.with_)]  # links say where its ends lead
        box = box_of(name, node, catalog, [describe(node), *said])
        return layout.Figure(box.width, box.height, [box])
    children = {n: _node_figure(n, child, catalog) for n, child in children_of(node).items()}
    inside = _inside(children, outcomes_shown(node), links_of(node))
    words = describe(node) + (f", only if {node.precondition}" if node.precondition else "")
    header = ICON + layout.text_width(name, layout.NAME_SIZE, bold=True) + 10
    header += layout.text_width(words, layout.TEXT_SIZE)
    width = max(inside.width, header) + 2 * _FRAME_PAD
    height = _HEADER + inside.height + _FRAME_PAD
    frame = layout.Box(0, 0, width, height, kind_of(node), name, (words,), node.doc, True)
    figure = layout.Figure(width, height, [frame])
    figure.add(inside, (width - inside.width) / 2, _HEADER)
    return figure


def _inside(children: dict[str, layout.Figure], outcomes: dict[str, str], links: list[Link]) -> layout.Figure:
    loops = {link.source: link for link in links if link.source == link.target and not link.to_outcome}
    items: dict[str, layout.Item] = {}
    if any(not link.source for link in links):
        items[""] = layout.Item(_START, _START)
    for name, child in children.items():
        room = 2 * (_LOOP + layout.text_width(loops[name].label, layout.TEXT_SIZE) + 4) if name in loops else 0.0
        items[name] = layout.Item(child.width + room, child.height)
    for name in outcomes:
        items[_pill(name)] = layout.Item(layout.text_width(name, layout.TEXT_SIZE) + 36, _PILL_HEIGHT)
    if not items:
        return layout.Figure()
    shown = [link for link in links if link not in loops.values()]
    edges = []
    for link in shown:
        size = (layout.text_width(link.label, layout.TEXT_SIZE) + 8, _LABEL_HEIGHT) if link.label else (0.0, 0.0)
        edges.append(layout.Edge(link.source, _pill(link.target) if link.to_outcome else link.target, size))
    placed = layout.place(items, edges, [_pill(name) for name in outcomes], _GAP, _RANK_GAP)
    figure = layout.Figure(placed.width, placed.height)
    ends = _ends(items, edges, placed, {n: c.width for n, c in children.items()})
    figure.lines += [_line(link, edge, at, placed) for link, edge, at in zip(shown, edges, ends, strict=True)]
    for name, child in children.items():
        item, top = items[name], placed.tops[items[name].rank]
        figure.add(child, item.x - child.width / 2, top)
        if name in loops:
            figure.lines.append(_loop(loops[name], item.x + child.width / 2, top, child.height))
    for name, meaning in outcomes.items():
        item = items[_pill(name)]
        corner = item.x - item.width / 2, placed.tops[item.rank]
        figure.pills.append(layout.Pill(*corner, item.width, item.height, name, meaning))
    if "" in items:
        x, y = items[""].x - _START / 2, placed.tops[items[""].rank]
        figure.pills.append(layout.Pill(x, y, _START, _START, "", "start"))
    return figure


def _pill(outcome: str) -> str:
    return f"/{outcome}"  # no child's name has a slash


def _ends(
    items: dict[str, layout.Item], edges: list[layout.Edge], placed: layout.Placed, widths: dict[str, float]
) -> list[tuple[layout.Point, layout.Point]]:
    """Return where each edge leaves its source and meets its target, spread over the boxes' edges."""
    sides: dict[tuple[str, bool], list[tuple[float, int, bool]]] = {}
    for number, edge in enumerate(edges):
        down = items[edge.source].rank <= items[edge.target].rank
        first = edge.bends[0].x if edge.bends else items[edge.target].x
        end = edge.bends[-1].x if edge.bends else items[edge.source].x
        sides.setdefault((edge.source, down), []).append((first, number, True))
        sides.setdefault((edge.target, not down), []).append((end, number, False))
    points: dict[tuple[int, bool], layout.Point] = {}
    for (name, lower), touching in sides.items():
        item = items[name]
        width = widths.get(name, item.width) - 12
        step = min(_PORT_GAP, width / max(len(touching), 1))
        y = placed.tops[item.rank] + (item.height if lower else 0.0)
        for position, (_, number, leaving) in enumerate(sorted(touching)):
            x = item.x + (position - (len(touching) - 1) / 2) * step
            points[number, leaving] = (x, y)
    return [(points[number, True], points[number, False]) for number in range(len(edges))]


def _line(link: Link, edge: layout.Edge, ends: tuple[layout.Point, layout.Point], placed: layout.Placed) -> layout.Line:
    points = [ends[0]]
    for item in edge.bends:
        top = placed.tops[item.rank]
        bottom = top + placed.heights[item.rank]
        down = ends[0][1] <= ends[1][1]
        points.extend([(item.x, top), (item.x, bottom)] if down else [(item.x, bottom), (item.x, top)])
    points.append(ends[1])
    at = (0.0, 0.0)
    if edge.label_item is not None:
        rank = edge.label_item.rank
        at = (edge.label_item.x, placed.tops[rank] + placed.heights[rank] / 2)
    return layout.Line(tuple(points), link.label, at)


def _loop(link: Link, x: float, top: float, height: float) -> layout.Line:
    """Return a line from a box's right side to itself."""
    low, high = top + min(height, 60) * 0.7, top + min(height, 60) * 0.3
    out = x + _LOOP - 8
    at = (out + 6 + layout.text_width(link.label, layout.TEXT_SIZE) / 2, (low + high) / 2)
    return layout.Line(((x, low), (out, low), (out, high), (x, high)), link.label, at)
