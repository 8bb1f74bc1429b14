"""Boxes and lines of a drawing with their places, and how they are laid out: trees, and rows like words of a text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import sqrt
from typing import Literal

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
    path: str = ""


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
    """A line through points; curved where they aren't one below the other, along `axis` where it leaves them."""

    points: tuple[Point, ...]
    label: str = ""
    label_at: Point = (0.0, 0.0)
    arrow: bool = True
    axis: Literal["x", "y"] = "y"


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


SCREEN = 700.0
"""From the first to the last child of a parent that stands at their middle [px]."""


@dataclass(slots=True)
class TreeItem:
    """A node of the tree to lay out: its box's height [px], its children, and its middle, set by `place_tree`."""

    height: float
    below: list[TreeItem] = field(default_factory=list)
    y: float = 0.0


def is_tall(item: TreeItem) -> bool:
    """Tell whether a item that `place_tree` has placed stands beside the first of its children, not at their middle."""
    return bool(item.below) and item.below[-1].y - item.below[0].y > SCREEN


def place_tree(root: TreeItem, gap: float) -> None:
    """Set `y` of every item; boxes of one column are `gap` apart at least [px]."""
    order: list[tuple[TreeItem, int]] = []
    todo = [(root, 0)]
    while todo:
        item, depth = todo.pop()
        order.append((item, depth))
        todo.extend((child, depth + 1) for child in reversed(item.below))
    contours: dict[int, tuple[list[float], list[float]]] = {}
    shifts: dict[int, list[float]] = {}
    for item, _ in reversed(order):
        shifts[id(item)] = _join(item, [contours.pop(id(c)) for c in item.below], contours, gap)
    for item, _ in order:
        for child, shift in zip(item.below, shifts[id(item)], strict=True):
            child.y = item.y + shift


def _join(
    item: TreeItem,
    parts: list[tuple[list[float], list[float]]],
    contours: dict[int, tuple[list[float], list[float]]],
    gap: float,
) -> list[float]:
    """Stack the children's contours; return their shifts relative to the item's middle."""
    shifts: list[float] = []
    top: list[float] = []
    bottom: list[float] = []
    for upper, lower in parts:
        shift = max((b - u + gap for b, u in zip(bottom, upper, strict=False)), default=0.0)
        shifts.append(shift)
        top = [*top, *(u + shift for u in upper[len(top) :])]
        bottom = [low + shift for low in lower] + bottom[len(lower) :]
    middle = (shifts[0] + shifts[-1]) / 2 if shifts and shifts[-1] - shifts[0] <= SCREEN else 0.0
    half = item.height / 2
    contours[id(item)] = ([-half, *(t - middle for t in top)], [half, *(b - middle for b in bottom)])
    return [shift - middle for shift in shifts]


_CHILD_GAP, _ROW_GAP = 34.0, 30.0
_LONGEST_COLUMN = 4
"""Up to so many children stand one below the other."""
_ASPECT = 1.5


def is_long(children: Sequence[Figure]) -> bool:
    """Tell whether one column would be too long."""
    return len(children) > _LONGEST_COLUMN and sum(child.height + _ROW_GAP for child in children) > 700


def rows_figure(children: Sequence[Figure], label: str) -> Figure:
    """Lay out children in rows; `label` stands at each link."""
    gap = _CHILD_GAP + (text_width(label, TEXT_SIZE) if label else 0.0)
    area = sum((c.width + gap) * (c.height + _ROW_GAP) for c in children)
    widest = max(sqrt(area * _ASPECT), *(c.width for c in children))
    figure = Figure()
    x = y = tallest = 0.0
    before: tuple[float, float, Figure] | None = None
    for child in children:
        if x > 0 and x + child.width > widest:
            x, y, tallest = 0.0, y + tallest + _ROW_GAP, 0.0
        if before is not None:
            figure.lines.append(_link(before, (x, y, child), label))
        figure.add(child, x, y)
        before = (x, y, child)
        tallest = max(tallest, child.height)
        figure.width = max(figure.width, x + child.width)
        x += child.width + gap
    figure.height = y + tallest
    return figure


def _link(one: tuple[float, float, Figure], other: tuple[float, float, Figure], label: str) -> Line:
    (x, y, left), (to_x, to_y, right) = one, other
    if y == to_y:
        level = y + min(left.height, right.height, 56.0) / 2
        ends = ((x + left.width, level), (to_x, level))
        return Line(ends, label, ((ends[0][0] + to_x) / 2, level), axis="x")
    from_x, middle = x + left.width / 2, to_y - _ROW_GAP / 2
    down_x = to_x + min(right.width / 2, 40.0)
    points = ((from_x, y + left.height), (from_x, middle), (down_x, middle), (down_x, to_y))
    return Line(points, label, ((from_x + down_x) / 2, middle))
