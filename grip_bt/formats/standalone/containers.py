"""How the file makes each container: with py_trees' own class where it does the same, else by the kind's own source."""

from __future__ import annotations

from grip_bt.base.errors import NotExpressibleError
from grip_bt.compilers.resolve import Part
from grip_bt.formats.expressible import require_expressible
from grip_bt.formats.python_source import Bracketed, Raw, call
from grip_bt.formats.standalone.builder import TARGET
from grip_bt.task import model
from grip_bt.task.parts import Edges

from .builder import ModuleBuilder, is_fresh
from .leaves import function_of, value_of

_FOREVER = -1
"""What py_trees' Repeat takes for a number without limit."""
_COMMON = {"doc", "precondition", "on", "x", "kind", "data", "outcomes", "children", "child"}
_OWN: dict[type, set[str]] = {
    model.Sequence: {"memory"},
    model.Fallback: {"memory"},
    model.Parallel: {"retick", "order"},
    model.Retry: {"times"},
    model.Repeat: {"times"},
    model.Timeout: {"seconds", "child_first"},
    model.Guard: {"if_"},
    model.Invert: set(),
    model.Force: {"as_"},
}
"""Kinds that py_trees has too, and what its classes can say of them."""


def container(part: Part, children: list[str], builder: ModuleBuilder) -> Bracketed:
    """Return the expression that makes a container of nodes that were made before it, by their names.

    Raises:
        NotExpressibleError: such a file can't do the same.
    """
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
    try:
        require_expressible(part.path, part.node, _OWN, TARGET, _COMMON)
    except NotExpressibleError:
        return None
    match part.node:
        case model.Sequence(memory=memory):
            return "py_trees.composites.Sequence", {"memory": memory}
        case model.Fallback(memory=memory):
            return "py_trees.composites.Selector", {"memory": memory}
        case model.Parallel(retick=retick):
            again = "synchronise=False" if retick else ""
            policy = Raw(f"py_trees.common.ParallelPolicy.SuccessOnAll({again})")
            return "py_trees.composites.Parallel", {"policy": policy}
        case model.Retry(times=times):
            return "py_trees.decorators.Retry", {"num_failures": times}
        case model.Repeat(times=times):
            return "py_trees.decorators.Repeat", {"num_success": _FOREVER if times is None else times}
        case model.Timeout(seconds=seconds, child_first=True) if not builder.grip:
            return "py_trees.decorators.Timeout", {"duration": seconds}
        case model.Guard(if_=text) if not builder.codes:
            return "py_trees.decorators.EternalGuard", {"condition": function_of(text, part, builder)}
        case model.Invert():
            return "py_trees.decorators.Inverter", {}
        case model.Force(as_=forced):
            name = "FailureIsSuccess" if forced == "success" else "SuccessIsFailure"
            return f"py_trees.decorators.{name}", {}
    return None


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
