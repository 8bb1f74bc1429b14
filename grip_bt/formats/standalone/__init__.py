"""A task as one Python file that needs py_trees, and grip only where a leaf is grip's own."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Mapping
from pathlib import Path

from grip_bt.base.errors import NotExpressibleError
from grip_bt.codegen.render import template
from grip_bt.compilers.resolve import Part, Resolved, resolve
from grip_bt.compilers.scopes import UNSET
from grip_bt.formats.python_source import Bracketed, Raw, call, comment, literal, remarked, statement
from grip_bt.formats.pytrees.classes import SAID, class_for
from grip_bt.formats.standalone.builder import ORDER, TARGET, ModuleBuilder, asks_for_codes, is_fresh
from grip_bt.formats.xml_trees import require_expressible
from grip_bt.task import model
from grip_bt.task.catalog import AllowedImports, Catalog
from grip_bt.task.parts import Edges

from .leaves import foreign, function_of, initial, is_file, leaf, manifest_text, needs_grip, value_of

_COMMON = ("precondition", "on", "x", "data", "outcomes")
_OWN = {**SAID, model.Parallel: ("retick", "order")}
"""Kinds that py_trees has too, and what its classes can say of them."""


def container(part: Part, children: list[str], builder: ModuleBuilder) -> Bracketed:
    """Return what makes a container of nodes by their names. Raises NotExpressibleError: no such file does that."""
    kind, names = part.node, [Raw(name) for name in children]
    assert isinstance(kind, model.Kind), "leaves are made elsewhere"
    if isinstance(kind, model.Subtask):
        raise NotExpressibleError(part.path, "a subtask", TARGET)
    if getattr(kind, "cancel", "halt") == "ask":
        raise NotExpressibleError(part.path, f"`cancel: ask` of a {kind.kind}", TARGET)
    if found := _of_py_trees(part, builder):
        class_name, settings = found
        below = {"child": names[0]} if "child" in type(kind).model_fields else {"children": names}
        return call(class_name, part.name, **below, **settings)
    builder.parts |= {"kinds", "container"}
    asked: dict[str, Raw] = {}
    for key in kind.conditions:
        if getattr(kind, key):
            asked[key] = function_of(getattr(kind, key), part, builder)
    for key in kind.values:
        asked[key] = value_of(getattr(kind, key), part, builder)
    seen = builder.visible(part)
    asked |= {key: Raw(f"{seen[getattr(kind, key)]}.get") for key in kind.reads}
    asked |= {key: Raw(f"{seen[getattr(kind, key)]}.set") for key in kind.puts}
    builder.parts |= {"variable"} if kind.reads or kind.puts else set()
    builder.parts |= {"same"} if kind.values else set()
    given = {
        "outcomes": {label: Raw(f"Status.{meaning.upper()}") for label, meaning in kind.outcomes.items()},
        "exits": table(part.exits),
        "edges": table(part.edges),
        "asked": asked,
    }
    made = builder.kinds.made(part, kind)
    return call("Container", part.name, made, names, **{key: said for key, said in given.items() if said})


def _of_py_trees(part: Part, builder: ModuleBuilder) -> tuple[str, dict[str, object]] | None:
    """Return class and arguments of py_trees' own class that does the same; None where there is none."""
    node = part.node
    try:
        require_expressible(part.path, node, (*_OWN.get(type(node), ()), *_COMMON), TARGET)
    except NotExpressibleError:
        return None
    match node:
        case model.Parallel(retick=retick):
            again = "synchronise=False" if retick else ""
            policy = Raw(f"py_trees.common.ParallelPolicy.SuccessOnAll({again})")
            return "py_trees.composites.Parallel", {"policy": policy}
        case model.Guard(if_=text) if not builder.codes:
            return "py_trees.decorators.EternalGuard", {"condition": function_of(text, part, builder)}
        case model.Guard():
            return None
        case model.Timeout() if builder.grip:
            return None
    found = class_for(node)
    return found and (f"py_trees.{'composites' if 'memory' in found[1] else 'decorators'}.{found[0]}", found[1])


def wrapped(part: Part, made: Bracketed, inner: str, builder: ModuleBuilder) -> list[tuple[str, Bracketed]]:
    """Return (name, expression) of a node and of what stands around it for its variables and its precondition."""
    rows = [(inner, made)]
    if is_fresh(part):
        builder.parts |= {"scope", "variable"}
        cells = [Raw(builder.variables[id(cell)]) for cell in part.scope.cells.values()]
        name = builder.identifiers.take(f"fresh_{inner}")
        rows.append((name, call("Scope", part.name, Raw(rows[-1][0]), cells)))
    if part.node.precondition:
        builder.parts.add("precondition")
        test = function_of(part.node.precondition, part, builder, around=True)
        name = builder.identifiers.take(f"{inner}_if")
        rows.append((name, call("Precondition", part.name, Raw(rows[-1][0]), test)))
    return rows


def table(edges: Edges) -> dict[str, dict[str, str]]:
    """Return edges as child -> `outcome` or `outcome.code` -> target."""
    rows: dict[str, dict[str, str]] = {}
    for (child, outcome, code), target in edges:
        rows.setdefault(child, {})[outcome if code is None else f"{outcome}.{code}"] = target
    return rows


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
_OWN_LEAVES = "It imports grip, since leaves of it are grip's own: they get the robot's parts from the run's context."


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
            made = call("Variable", cell.name, *(() if cell.value is UNSET else (initial(cell.value, builder),)))
            builder.statements.append(remarked(statement(name, made), cell.type))
    values = _template_values(resolved, catalog, builder, _nodes(resolved, builder, catalog.code), folder)
    return template(__package__, "module.py.j2").render(values)


def _nodes(resolved: Resolved, builder: ModuleBuilder, code: AllowedImports) -> str:
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
    others = [(catalog.get(id), name) for id, name in builder.manifests.items()]
    manifests = [manifest_text(manifest, name, folder) for manifest, name in others]
    if any(is_file(manifest) for manifest, _ in others):
        manifests.insert(0, "HERE = Path(__file__).parent")
    if builder.builtin:
        manifests.insert(0, "NODES = Catalog.builtin()")
    head = [f"Task {resolved.task.name}, written by `grip convert --to pytrees-py`.", resolved.task.doc]
    head += [_OWN_LEAVES] if builder.grip else []
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
