"""Text for Graphviz, which makes its own layout, and for Mermaid, whose charts are drawn by viewers of Markdown."""

from __future__ import annotations

from collections.abc import Iterator

from grip_bt.task import AnyNode, Leaf, Task, children_of, join, walk
from grip_bt.task.catalog import Catalog
from grip_bt.task.model import kind_of

from .views import GLYPHS, View, describe, details, links_of, outcomes_shown


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
