"""SVG with a layout of our own; it needs no fonts, scripts or style sheets from elsewhere."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from xml.sax.saxutils import escape, quoteattr

from grip_bt.task import KINDS, Task, walk
from grip_bt.task.catalog import Catalog

from .layout import NAME_SIZE, TEXT_SIZE, Box, Line, Pill, text_width
from .views import ICON, LINE_HEIGHT, View, flow_figure, tree_figure

_COLOURS = {  # fill, border
    "leaf": ("#ffffff", "#5b6470"),
    "sequence": ("#eaf1fc", "#3f6fb5"),
    "fallback": ("#fdf3e1", "#b97a14"),
    "parallel": ("#f2eafb", "#7a4fb3"),
    "state_machine": ("#e6f5ef", "#2c8262"),
}
_DECORATOR = ("#f4f4f2", "#77736a")
_MEANINGS = {"success": ("#e5f4e8", "#2f7d3f"), "failure": ("#fbeae8", "#b0392c")}
_STATUS = {**_MEANINGS, "running": ("#fff4cf", "#a87b00")}
_FONT = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif"
_INK, _QUIET, _LINE, _PAPER = "#1d2329", "#59626c", "#6b747e", "#fcfcfb"
_TICK = {"success": "M-4 0l3 3l5-6", "failure": "M-3-3l6 6M3-3l-6 6"}


def to_svg(task: Task, catalog: Catalog, view: View = "tree", status: Mapping[str, str] = MappingProxyType({})) -> str:
    """Return a picture of a task.

    Args:
        task: the task; it need not be valid.
        catalog: where the nodes' documentation is, for the titles that a pointer shows.
        view: `tree` (every node a box, order from top to bottom) or `flow` (containers as frames, links inside).
        status: node -> `running`, `success` or `failure`, which colours its box in a tree.
    """
    figure = tree_figure(task, catalog) if view == "tree" else flow_figure(task, catalog)
    width, height = round(figure.width), round(figure.height)
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        f'viewBox="0 0 {width} {height}" role="img" font-family="{_FONT}" font-size="{TEXT_SIZE:g}">'
    )
    arrow = (
        '<defs><marker id="arrow" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" '
        f'orient="auto-start-reverse"><path d="M0 .8L7.5 4L0 7.200z" fill="{_LINE}"/></marker></defs>'
    )
    body = [
        f"<title>{escape(task.name)}, {view} view</title>",
        arrow,
        f'<rect width="{width}" height="{height}" fill="{_PAPER}"/>',
        *(_box(box, status.get(path, "")) for box, (path, _) in zip(figure.boxes, walk(task.root), strict=True)),
        *(_path(line) for line in figure.lines),
        *(_pill(pill) for pill in figure.pills),
        *(label for line in figure.lines for label in _label(line)),
    ]
    return "\n".join([head, *body, "</svg>"]) + "\n"


def _number(value: float) -> str:
    return f"{value:.1f}".removesuffix(".0")


def _text(x: float, y: float, words: str, **attributes: str) -> str:
    more = "".join(f" {k.replace('_', '-')}={quoteattr(v)}" for k, v in attributes.items())
    return f'<text x="{_number(x)}" y="{_number(y)}"{more}>{escape(words)}</text>'


def _box(box: Box, status: str) -> str:
    fill, border = _STATUS.get(status) or _COLOURS.get(box.kind, _DECORATOR)
    radius = 10 if box.frame else 6
    parts = [f"<title>{escape(box.title)}</title>"] if box.title else []
    parts.append(
        f'<rect x="{_number(box.x)}" y="{_number(box.y)}" width="{_number(box.width)}" '
        f'height="{_number(box.height)}" rx="{radius}" fill="{fill}" stroke="{border}" stroke-width="1.3"/>'
    )
    x, y = box.x + 10, box.y + 10 + NAME_SIZE * 0.85
    if box.kind != "leaf":
        icon = KINDS[box.kind].icon
        parts.append(
            f'<path transform="translate({_number(x)} {_number(y - 12.5)}) scale(.95)" d="{icon}" fill="none" '
            f'stroke="{border}" stroke-width="1.6" stroke-linecap="round" stroke-linejoin="round"/>'
        )
    left = x + (ICON if box.kind != "leaf" else 0)
    name = {"font_size": f"{NAME_SIZE:g}", "font_weight": "bold", "fill": _INK}
    parts.append(_text(left, y, box.name, **name))
    if box.frame:
        beside = left + text_width(box.name, NAME_SIZE, bold=True) + 10
        parts.extend(_text(beside, y, line, fill=_QUIET) for line in box.lines)
    else:
        parts.extend(_text(x, y + LINE_HEIGHT * row, line, fill=_QUIET) for row, line in enumerate(box.lines, 1))
    return f"<g>{''.join(parts)}</g>"


def _path(line: Line) -> str:
    head = ' marker-end="url(#arrow)"' if line.arrow else ""
    return f'<path d="{_curve(line)}" fill="none" stroke="{_LINE}" stroke-width="1.3"{head}/>'


def _curve(line: Line) -> str:
    x, y = line.points[0]
    commands = [f"M{_number(x)} {_number(y)}"]
    for to_x, to_y in line.points[1:]:
        if abs(to_x - x) < 0.5 or abs(to_y - y) < 0.5:
            commands.append(f"L{_number(to_x)} {_number(to_y)}")
        else:
            middle = (y + to_y) / 2
            points = " ".join(f"{_number(px)} {_number(py)}" for px, py in ((x, middle), (to_x, middle), (to_x, to_y)))
            commands.append(f"C{points}")
        x, y = to_x, to_y
    return "".join(commands)


def _label(line: Line) -> Iterator[str]:
    if line.label:
        x, y = line.label_at
        width = text_width(line.label, TEXT_SIZE) + 4
        yield (
            f'<rect x="{_number(x - width / 2)}" y="{_number(y - 7.5)}" width="{_number(width)}" height="15" '
            f'rx="3" fill="{_PAPER}" fill-opacity=".85"/>'
        )
        yield _text(x, y + 4, line.label, text_anchor="middle", fill=_INK)


def _pill(pill: Pill) -> str:
    middle = pill.y + pill.height / 2
    if not pill.name:
        return f'<circle cx="{_number(pill.x + pill.width / 2)}" cy="{_number(middle)}" r="6" fill="{_INK}"/>'
    fill, border = _MEANINGS[pill.meaning]
    tick = _TICK[pill.meaning]
    return (
        f'<g><rect x="{_number(pill.x)}" y="{_number(pill.y)}" width="{_number(pill.width)}" '
        f'height="{_number(pill.height)}" rx="11" fill="{fill}" stroke="{border}" stroke-width="1.3"/>'
        f'<path transform="translate({_number(pill.x + 15)} {_number(middle)})" d="{tick}" fill="none" '
        f'stroke="{border}" stroke-width="1.8"/>' + _text(pill.x + 26, middle + 4, pill.name, fill=_INK) + "</g>"
    )
