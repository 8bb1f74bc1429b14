"""A tree from left to right, as narrow as its contours allow.

Reingold & Tilford, "Tidier Drawings of Trees" (1981), with boxes of any height: subtrees are stacked so closely that
no two boxes of one column touch, and a parent stands at the middle of its children; beside the first of them where they
are spread over more than a screen, so that whoever reads from the top meets every parent before its children.
"""

from __future__ import annotations

from dataclasses import dataclass, field

SCREEN = 700.0
"""From the first to the last child of a parent that stands at their middle [px]."""


@dataclass(slots=True)
class Twig:
    """A node of the tree to lay out.

    Attributes:
        height: of its box [px].
        below: its children, from top to bottom.
        y: middle of its box; set by `stack`.
    """

    height: float
    below: list[Twig] = field(default_factory=list)
    y: float = 0.0


def is_spread(twig: Twig) -> bool:
    """Tell whether a twig that `stack` has placed stands beside the first of its children, not at their middle."""
    return bool(twig.below) and twig.below[-1].y - twig.below[0].y > SCREEN


def stack(root: Twig, gap: float) -> None:
    """Set `y` of every twig.

    Args:
        root: the tree.
        gap: least distance between boxes of one column [px].
    """
    order: list[tuple[Twig, int]] = []
    todo = [(root, 0)]
    while todo:
        twig, depth = todo.pop()
        order.append((twig, depth))
        todo.extend((child, depth + 1) for child in reversed(twig.below))
    contours: dict[int, tuple[list[float], list[float]]] = {}
    shifts: dict[int, list[float]] = {}
    for twig, _ in reversed(order):
        shifts[id(twig)] = _join(twig, [contours.pop(id(c)) for c in twig.below], contours, gap)
    for twig, _ in order:
        for child, shift in zip(twig.below, shifts[id(twig)], strict=True):
            child.y = twig.y + shift


def _join(
    twig: Twig,
    parts: list[tuple[list[float], list[float]]],
    contours: dict[int, tuple[list[float], list[float]]],
    gap: float,
) -> list[float]:
    """Stack the children's contours; return their shifts relative to the twig's middle."""
    shifts: list[float] = []
    top: list[float] = []
    bottom: list[float] = []
    for upper, lower in parts:
        shift = max((b - u + gap for b, u in zip(bottom, upper, strict=False)), default=0.0)
        shifts.append(shift)
        top = [*top, *(u + shift for u in upper[len(top) :])]
        bottom = [low + shift for low in lower] + bottom[len(lower) :]
    middle = (shifts[0] + shifts[-1]) / 2 if shifts and shifts[-1] - shifts[0] <= SCREEN else 0.0
    half = twig.height / 2
    contours[id(twig)] = (
        [-half, *(t - middle for t in top)],
        [half, *(b - middle for b in bottom)],
    )
    return [shift - middle for shift in shifts]
