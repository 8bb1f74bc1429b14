"""Pictures of tasks: SVG with a layout of our own, and text for Graphviz and Mermaid.

The SVG needs no fonts, scripts or style sheets from elsewhere. Graphviz makes its own layout, Mermaid's charts are
drawn by viewers of Markdown.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from xml.sax.saxutils import escape, quoteattr

from grip_bt.task import KINDS, AnyNode, Leaf, Task, children_of, join, walk
from grip_bt.task.catalog import Catalog

from .layout import NAME_SIZE, TEXT_SIZE, Box, Line, Pill, text_width
from .views import (
    GLYPHS,
    ICON,
    LINE_HEIGHT,
    View,
    describe,
    details,
    flow_figure,
    kind_of,
    links_of,
    outcomes_shown,
    tree_figure,
)

__all__ = ["View", "to_dot", "to_mermaid", "to_svg"]

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


def to_dot(task: Task, catalog: Catalog, view: View = "tree") -> str:
    """Return a task as a Graphviz graph; node ids are paths."""
    lines = [f"digraph {_dot_text(task.name)} {{", '  node [shape=box, style=rounded, fontname="sans-serif"];']
    if view == "tree":
        lines.append("  rankdir=LR;")
        for path, words, below in _tree(task):
            lines.append(f"  {_dot_text(path)} [label={_dot_text(words)}];")
            lines += [f"  {_dot_text(path)} -> {_dot_text(child)};" for child in below]
    else:
        lines.append("  compound=true;")
        lines.extend(_dot_flow(task.name, "/", task.root, "  "))
    return "\n".join([*lines, "}"]) + "\n"


def _dot_text(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'


def _words(name: str, node: AnyNode) -> str:
    glyph = GLYPHS[kind_of(node)]
    return f"{glyph} {name}".strip() + "\n" + describe(node)


def _tree(task: Task) -> Iterator[tuple[str, str, list[str]]]:
    for path, node in walk(task.root):
        name = task.name if path == "/" else path.rpartition("/")[2]
        words = "\n".join([_words(name, node), *details(node)])
        yield path, words, [join(path, child) for child in children_of(node)]


def _dot_flow(name: str, path: str, node: AnyNode, space: str) -> Iterator[str]:
    if isinstance(node, Leaf):
        yield f"{space}{_dot_text(path)} [label={_dot_text(_words(name, node))}];"
        return
    yield f"{space}subgraph {_dot_text('cluster ' + path)} {{"
    yield f"{space}  label={_dot_text(_words(name, node))};"
    # edges can't end at a cluster: they end at this point in it and are clipped at its border
    yield f'{space}  {_dot_text(path)} [shape=point, style=invis, label=""];'
    for child, below in children_of(node).items():
        yield from _dot_flow(child, join(path, child), below, space + "  ")
    for outcome, meaning in outcomes_shown(node).items():
        sign = "✓" if meaning == "success" else "✗"
        yield f"{space}  {_dot_text(_exit(path, outcome))} [label={_dot_text(f'{sign} {outcome}')}, shape=ellipse];"
    children = children_of(node)
    for link in links_of(node):
        source, target = join(path, link.source), join(path, link.target)
        clip = []
        if not link.source:
            source = f"{path}#start"
            yield f"{space}  {_dot_text(source)} [shape=point, width=0.12];"
        elif not isinstance(children[link.source], Leaf):
            clip.append(f"ltail={_dot_text('cluster ' + source)}")
        if link.to_outcome:
            target = _exit(path, link.target)
        elif link.target in children and not isinstance(children[link.target], Leaf):
            clip.append(f"lhead={_dot_text('cluster ' + target)}")
        attributes = ", ".join([f"label={_dot_text(link.label)}", *clip])
        yield f"{space}  {_dot_text(source)} -> {_dot_text(target)} [{attributes}];"
    yield f"{space}}}"


def _exit(path: str, outcome: str) -> str:
    return f"{path}#{outcome}"


def to_mermaid(task: Task, catalog: Catalog, view: View = "tree") -> str:
    """Return a task as a Mermaid flow chart."""
    ids = {path: f"n{number}" for number, (path, _) in enumerate(walk(task.root))}
    if view == "tree":
        lines = ["flowchart LR"]
        for path, words, below in _tree(task):
            lines.append(f"  {ids[path]}[{_mermaid_text(words)}]")
            lines += [f"  {ids[path]} --- {ids[child]}" for child in below]
    else:
        lines = ["flowchart TB", *_mermaid_flow(task.name, "/", task.root, ids, "  ")]
    return "\n".join(lines) + "\n"


def _mermaid_text(text: str) -> str:
    """Return a text as a Mermaid string; what it would read as markup becomes entities."""
    for sign, entity in (("#", "#35;"), ('"', "#quot;"), ("<", "#lt;"), (">", "#gt;"), ("`", "#96;")):
        text = text.replace(sign, entity)
    return '"' + text.replace("\n", "<br/>") + '"'


def _mermaid_flow(name: str, path: str, node: AnyNode, ids: dict[str, str], space: str) -> Iterator[str]:
    mine = ids[path]
    if isinstance(node, Leaf):
        yield f"{space}{mine}[{_mermaid_text(_words(name, node))}]"
        return
    yield f"{space}subgraph {mine}[{_mermaid_text(_words(name, node))}]"
    for child, below in children_of(node).items():
        yield from _mermaid_flow(child, join(path, child), below, ids, space + "  ")
    outcomes = list(outcomes_shown(node))
    for number, (outcome, meaning) in enumerate(outcomes_shown(node).items()):
        sign = "✓" if meaning == "success" else "✗"
        yield f"{space}  {mine}o{number}([{_mermaid_text(f'{sign} {outcome}')}])"
    for link in links_of(node):
        source = ids[join(path, link.source)] if link.source else f"{mine}s"
        if not link.source:
            yield f"{space}  {source}(( ))"
        target = f"{mine}o{outcomes.index(link.target)}" if link.to_outcome else ids.get(join(path, link.target))
        label = f"|{_mermaid_text(link.label)}|" if link.label else ""
        if target is not None:
            yield f"{space}  {source} -->{label} {target}"
    yield f"{space}end"
