"""Children in plain order, laid out like the words of a text: in rows from left to right."""

from __future__ import annotations

from collections.abc import Sequence
from math import sqrt

from .figure import TEXT_SIZE, Figure, Line, text_width

_GAP, _ROW_GAP = 34.0, 30.0
_LONGEST_COLUMN = 4
"""Up to so many children stand one below the other."""
_ASPECT = 1.5


def is_long(children: Sequence[Figure]) -> bool:
    """Tell whether one column would be too long."""
    return len(children) > _LONGEST_COLUMN and _height(children) > 700


def _height(children: Sequence[Figure]) -> float:
    return sum(child.height + _ROW_GAP for child in children)


def rows_figure(children: Sequence[Figure], label: str) -> Figure:
    """Lay out children in rows.

    Args:
        children: in order.
        label: stands at each link.
    """
    gap = _GAP + (text_width(label, TEXT_SIZE) if label else 0.0)
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
