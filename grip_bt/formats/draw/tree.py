"""The tree view: every node a box, the root at the left, order from top to bottom."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace

from grip_bt.task import AnyNode, Leaf, Task, walk
from grip_bt.task.catalog import Catalog

from .figure import NAME_SIZE, TEXT_SIZE, Box, Figure, Line, shortened, text_width
from .scheme import describe, details, kind_of
from .tidy import Twig, is_spread, stack

_PAD, _COLUMN_GAP, _ROW_GAP, _MARGIN = 10.0, 44.0, 12.0, 20.0
LINE_HEIGHT = 15.0
ICON = 20.0


def box_of(name: str, node: AnyNode, catalog: Catalog, lines: list[str]) -> Box:
    """Return a node's box at the origin, as large as its words need."""
    shown = tuple(shortened(line) for line in lines)
    kind = kind_of(node)
    icon = 0.0 if kind == "leaf" else ICON
    width = icon + text_width(shortened(name), NAME_SIZE, bold=True)
    width = max([width, 70.0, *(text_width(line, TEXT_SIZE) for line in shown)])
    title = node.doc
    if not title and isinstance(node, Leaf) and node.node in catalog:
        title = catalog.get(node.node).doc
    height = 2 * _PAD + NAME_SIZE + len(shown) * LINE_HEIGHT
    return Box(0, 0, width + 2 * _PAD, height, kind, shortened(name), shown, title)


def tree_figure(task: Task, catalog: Catalog) -> Figure:
    """Lay out a task as a tree."""
    boxes: dict[str, Box] = {}
    twigs: dict[str, Twig] = {}
    columns: defaultdict[int, float] = defaultdict(float)
    depth: dict[str, int] = {}
    for path, node in walk(task.root):
        name = task.name if path == "/" else path.rpartition("/")[2]
        box = box_of(name, node, catalog, [describe(node), *details(node)])
        boxes[path], twigs[path] = box, Twig(box.height)
        if path != "/":
            parent = _parent(path)
            twigs[parent].below.append(twigs[path])
            depth[path] = depth[parent] + 1
        else:
            depth[path] = 0
        columns[depth[path]] = max(columns[depth[path]], box.width)
    stack(twigs["/"], _ROW_GAP)
    return _placed(boxes, twigs, columns, depth)


def _parent(path: str) -> str:
    return path.rpartition("/")[0] or "/"


def _placed(boxes: dict[str, Box], twigs: dict[str, Twig], columns: dict[int, float], depth: dict[str, int]) -> Figure:
    left = [_MARGIN]
    for column in range(len(columns)):
        left.append(left[-1] + columns[column] + _COLUMN_GAP)
    up = min(t.y - t.height / 2 for t in twigs.values()) - _MARGIN
    figure = Figure(
        width=left[-1] - _COLUMN_GAP + _MARGIN,
        height=max(t.y + t.height / 2 for t in twigs.values()) - up + _MARGIN,
    )
    for path, box in boxes.items():
        x, y = left[depth[path]], twigs[path].y - up
        figure.boxes.append(replace(box, x=x, y=y - box.height / 2, path=path))
        if path != "/":
            parent = boxes[_parent(path)]
            start = left[depth[path] - 1] + parent.width
            bend = left[depth[path]] - _COLUMN_GAP  # every line of a column curves in the same place
            from_y = twigs[_parent(path)].y - up
            bend = max(start, bend)
            points: tuple[tuple[float, float], ...] = ((start, from_y), (bend, from_y), (x, y))
            if is_spread(twigs[_parent(path)]):  # curves as long as that would lie over each other
                trunk = (bend + x) / 2
                points = ((start, from_y), (trunk, from_y), (trunk, y), (x, y))
            figure.lines.append(Line(points, arrow=False, axis="x"))
    return figure
