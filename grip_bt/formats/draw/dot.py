"""Tasks for Graphviz, which then makes its own layout."""

from __future__ import annotations

from collections.abc import Iterator

from grip_bt.task import AnyNode, Leaf, Task, children_of, join, walk

from .scheme import GLYPHS, View, describe, details, kind_of, links_of, outcomes_shown


def to_dot(task: Task, view: View = "tree") -> str:
    """Return a task as a Graphviz graph; node ids are paths."""
    lines = [f"digraph {_quoted(task.name)} {{", '  node [shape=box, style=rounded, fontname="sans-serif"];']
    if view == "tree":
        lines.append("  rankdir=LR;")
        lines.extend(_tree(task))
    else:
        lines.append("  compound=true;")
        lines.extend(_flow(task.name, "/", task.root, "  "))
    return "\n".join([*lines, "}"]) + "\n"


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'


def _words(name: str, node: AnyNode) -> str:
    glyph = GLYPHS[kind_of(node)]
    return f"{glyph} {name}".strip() + "\n" + describe(node)


def _tree(task: Task) -> Iterator[str]:
    for path, node in walk(task.root):
        name = task.name if path == "/" else path.rpartition("/")[2]
        words = "\n".join([_words(name, node), *details(node)])
        yield f"  {_quoted(path)} [label={_quoted(words)}];"
        yield from (f"  {_quoted(path)} -> {_quoted(join(path, child))};" for child in children_of(node))


def _flow(name: str, path: str, node: AnyNode, space: str) -> Iterator[str]:
    if isinstance(node, Leaf):
        yield f"{space}{_quoted(path)} [label={_quoted(_words(name, node))}];"
        return
    yield f"{space}subgraph {_quoted('cluster ' + path)} {{"
    yield f"{space}  label={_quoted(_words(name, node))};"
    # edges can't end at a cluster: they end at this point in it and are clipped at its border
    yield f'{space}  {_quoted(path)} [shape=point, style=invis, label=""];'
    for child, below in children_of(node).items():
        yield from _flow(child, join(path, child), below, space + "  ")
    for outcome, meaning in outcomes_shown(node).items():
        sign = "✓" if meaning == "success" else "✗"
        yield f"{space}  {_quoted(_exit(path, outcome))} [label={_quoted(f'{sign} {outcome}')}, shape=ellipse];"
    children = children_of(node)
    for link in links_of(node):
        source, target = join(path, link.source), join(path, link.target)
        clip = []
        if not link.source:
            source = f"{path}#start"
            yield f"{space}  {_quoted(source)} [shape=point, width=0.12];"
        elif not isinstance(children[link.source], Leaf):
            clip.append(f"ltail={_quoted('cluster ' + source)}")
        if link.to_outcome:
            target = _exit(path, link.target)
        elif link.target in children and not isinstance(children[link.target], Leaf):
            clip.append(f"lhead={_quoted('cluster ' + target)}")
        attributes = ", ".join([f"label={_quoted(link.label)}", *clip])
        yield f"{space}  {_quoted(source)} -> {_quoted(target)} [{attributes}];"
    yield f"{space}}}"


def _exit(path: str, outcome: str) -> str:
    return f"{path}#{outcome}"
