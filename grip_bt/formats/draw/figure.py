"""A drawing as data: boxes, pills and lines with their places [px]; y points down."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
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
    """A node: a leaf or, as a frame, a container around others.

    Attributes:
        x: left edge.
        y: upper edge.
        width: outer width.
        height: outer height.
        kind: `leaf` or a container's kind.
        name: first line.
        lines: further lines.
        title: shown when the pointer rests on it.
        frame: whether other things are drawn inside.
        path: of the node.
    """

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
    """A line through points; curved where they aren't one below the other.

    Attributes:
        points: where it runs.
        label: its words.
        label_at: their centre.
        arrow: whether it ends with a head.
        axis: along which coordinate it leaves its points.
    """

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
