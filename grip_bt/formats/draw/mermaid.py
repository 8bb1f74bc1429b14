"""Tasks for Mermaid, which Markdown viewers draw."""

from __future__ import annotations

from collections.abc import Iterator

from grip_bt.task import AnyNode, Leaf, Task, children_of, join, walk

from .scheme import GLYPHS, View, describe, details, kind_of, links_of, outcomes_shown


def to_mermaid(task: Task, view: View = "tree") -> str:
    """Return a task as a Mermaid flow chart."""
    ids = {path: f"n{number}" for number, (path, _) in enumerate(walk(task.root))}
    if view == "tree":
        lines = ["flowchart LR", *_tree(task, ids)]
    else:
        lines = ["flowchart TB", *_flow(task.name, "/", task.root, ids, "  ")]
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    """Return a text as a Mermaid string; what it would read as markup becomes entities."""
    for sign, entity in (("#", "#35;"), ('"', "#quot;"), ("<", "#lt;"), (">", "#gt;"), ("`", "#96;")):
        text = text.replace(sign, entity)
    return '"' + text.replace("\n", "<br/>") + '"'


def _words(name: str, node: AnyNode) -> str:
    glyph = GLYPHS[kind_of(node)]
    return f"{glyph} {name}".strip() + "\n" + describe(node)


def _tree(task: Task, ids: dict[str, str]) -> Iterator[str]:
    for path, node in walk(task.root):
        name = task.name if path == "/" else path.rpartition("/")[2]
        yield f"  {ids[path]}[{_quoted(chr(10).join([_words(name, node), *details(node)]))}]"
        yield from (f"  {ids[path]} --- {ids[join(path, child)]}" for child in children_of(node))


def _flow(name: str, path: str, node: AnyNode, ids: dict[str, str], space: str) -> Iterator[str]:
    mine = ids[path]
    if isinstance(node, Leaf):
        yield f"{space}{mine}[{_quoted(_words(name, node))}]"
        return
    yield f"{space}subgraph {mine}[{_quoted(_words(name, node))}]"
    for child, below in children_of(node).items():
        yield from _flow(child, join(path, child), below, ids, space + "  ")
    outcomes = list(outcomes_shown(node))
    for number, (outcome, meaning) in enumerate(outcomes_shown(node).items()):
        sign = "✓" if meaning == "success" else "✗"
        yield f"{space}  {mine}o{number}([{_quoted(f'{sign} {outcome}')}])"
    for link in links_of(node):
        source = ids[join(path, link.source)] if link.source else f"{mine}s"
        if not link.source:
            yield f"{space}  {source}(( ))"
        target = f"{mine}o{outcomes.index(link.target)}" if link.to_outcome else ids.get(join(path, link.target))
        label = f"|{_quoted(link.label)}|" if link.label else ""
        if target is not None:
            yield f"{space}  {source} -->{label} {target}"
    yield f"{space}end"
