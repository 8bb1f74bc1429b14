"""A task as one Python file that needs py_trees, and grip only where a leaf is grip's own."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Mapping
from pathlib import Path

from grip_bt.compilers.resolve import Part, Resolved, resolve
from grip_bt.compilers.scopes import UNSET
from grip_bt.formats.python_source import call, comment, literal, remarked, statement, template
from grip_bt.task import model
from grip_bt.task.catalog import AllowedImports, Catalog

from .builder import ORDER, ModuleBuilder, asks_for_codes
from .containers import container, table, wrapped
from .leaves import foreign, is_file, leaf, manifest_text, needs_grip

_STANDARD: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("copy", "logging", "time"), ()),
    "collections.abc": ("Callable", "Iterator", "Mapping"),
    "numbers": ("Real",),
    "pathlib": ("Path",),
    "typing": ("Any", "NamedTuple"),
}
_OTHERS: dict[str, tuple[str, ...]] = {
    "grip_bt.task.catalog": ("Catalog", "Manifest", "load_implementation"),
    "grip_bt.nodes": ("Leaf",),
    "grip_bt.base.ports": ("Context",),
    "grip_bt.runtime": ("RunContext",),
    "py_trees.common": ("Status",),
}


def export(task: model.Task, catalog: Catalog, folder: Path | None = None) -> str:
    """Return a Python file that builds the tree of a task.

    The file's tree does what `grip_bt.compilers.to_tree` makes of the task, tick by tick. What only a run of grip
    does is not in it: the journal, waking on events (it is ticked at a period), and the types of values written.

    Args:
        task: the document.
        catalog: where the leaves' manifests are; whether their classes need grip is read in their source.
        folder: where the file will lie, for paths of code relative to it; by default the current one.

    Raises:
        InvalidTaskError: the task is wrong.
        NotExpressibleError: a part of it has no equivalent in such a file.
    """
    resolved = resolve(task, catalog)
    builder = ModuleBuilder(grip=needs_grip(resolved), codes=asks_for_codes(resolved))
    for scope in resolved.scopes:
        for cell in scope.cells.values():
            parent = scope.path.rsplit("/", 1)[-1]
            name = builder.identifiers.take(cell.name, f"{parent}_{cell.name}")
            builder.variables[id(cell)] = name
            builder.parts.add("variable")
            made = call("Variable", cell.name, *(() if cell.value is UNSET else (cell.value,)))
            builder.statements.append(remarked(statement(name, made), cell.type))
    values = _template_values(resolved, catalog, builder, _nodes(resolved, builder, catalog.code), folder)
    return template(__package__, "module.py.j2").render(values)


def _nodes(resolved: Resolved, builder: ModuleBuilder, code: AllowedImports) -> str:
    """Write the nodes, children first; return the root's name."""
    builtin = Catalog.builtin()
    names: dict[str, str] = {}
    order, stack = list[Part](), [resolved.root]
    while stack:
        order.append(stack.pop())
        stack.extend(order[-1].children)
    for part in reversed(order):
        parent = part.path.rsplit("/", 2)[-2] if "/" in part.path.strip("/") else "root"
        name = "root" if part.path == "/" else part.name
        inner = builder.identifiers.take(name, f"{parent}_{name}")
        if isinstance(part.node, model.Leaf):
            made = leaf(part, builder, builtin)
        elif isinstance(part.node, model.Foreign):
            made = foreign(part, builder, code)
        else:
            made = container(part, [names[child.path] for child in part.children], builder)
        rows = wrapped(part, made, inner, builder)
        if part.node.doc:
            builder.statements.append(comment(part.node.doc, 4))
        builder.statements += [statement(name, expression) for name, expression in rows]
        names[part.path] = rows[-1][0]
    return names["/"]


def _template_values(
    resolved: Resolved, catalog: Catalog, builder: ModuleBuilder, root: str, folder: Path | None
) -> dict[str, object]:
    """Return what the template fills in."""
    others = [(catalog.get(id), name) for id, name in builder.manifests.items()]
    manifests = [manifest_text(manifest, name, folder) for manifest, name in others]
    if any(is_file(manifest) for manifest, _ in others):
        manifests.insert(0, "HERE = Path(__file__).parent")
    if builder.builtin:
        manifests.insert(0, "NODES = Catalog.builtin()")
    head = [f"Task {resolved.task.name}, written by `grip convert --to pytrees-py`.", resolved.task.doc]
    if builder.grip:
        head += [
            "It imports grip, since leaves of it are grip's own: they get the robot's parts from the run's context."
        ]
    values: dict[str, object] = {
        "head": "\n#\n".join(comment(text) for text in head if text),
        "grip": builder.grip,
        "codes": builder.codes,
        "parts": [part for part in ORDER if part in builder.parts],
        "kinds": builder.kinds.text(),
        "asked": builder.kinds.questions,
        "manifests": "\n".join(manifests),
        "statements": builder.statements,
        "root": root,
        "ends": statement("ENDS", literal(table(resolved.ends).get("/", {})), 0),
    }
    body = template(__package__, "module.py.j2").render({**values, "standard_imports": (), "imports": ()})
    used = {node.id for node in ast.walk(ast.parse(body)) if isinstance(node, ast.Name)}
    standard = _lines(_STANDARD, used)
    modules = {module: list(names) for module, names in _OTHERS.items()}
    for module, classes in builder.imports.items():
        own = [name if name == local else f"{name} as {local}" for name, local in classes.items()]
        modules[module] = [*modules.get(module, ()), *own]
        used = used | set(own)
    imports = ["import py_trees", *_lines(dict(sorted(modules.items())), used)]
    return {**values, "standard_imports": standard, "imports": imports}


def _lines(modules: Mapping[str, Iterable[str]], used: set[str]) -> list[str]:
    """Return `import module`, or `from module import names` of the names that are used."""
    lines = []
    for module, names in modules.items():
        wanted = sorted({name for name in names if name in used})
        if wanted:
            lines.append(f"from {module} import {', '.join(wanted)}")
        elif not names and module in used:
            lines.append(f"import {module}")
    return lines
