"""How the file makes each container: with py_trees' own class where it does the same, else by the kind's own source."""

from __future__ import annotations

from grip_bt.base.errors import NotExpressibleError
from grip_bt.compilers.resolve import Part
from grip_bt.formats.expressible import require_expressible
from grip_bt.formats.python_source import Code, Items, call
from grip_bt.formats.standalone.plan import TARGET
from grip_bt.task import model
from grip_bt.task.edges import Edges

from .leaves import function_of, value_of
from .plan import Plan, is_fresh

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


def container(part: Part, children: list[str], plan: Plan) -> Items:
    """Return the expression that makes a container of nodes that were made before it.

    Args:
        part: the container.
        children: names of its children in the file.
        plan: told what else is needed.

    Raises:
        NotExpressibleError: such a file can't do the same.
    """
    kind, names = part.node, [Code(name) for name in children]
    assert isinstance(kind, model.Kind), "leaves are made elsewhere"
    if isinstance(kind, model.Subtask):
        raise NotExpressibleError(part.path, "a subtask", TARGET)
    if getattr(kind, "cancel", "halt") == "ask":
        raise NotExpressibleError(part.path, f"`cancel: ask` of a {kind.kind}", TARGET)
    if found := _of_py_trees(part, plan):
        class_name, settings = found
        below = {"child": names[0]} if "child" in type(kind).model_fields else {"children": names}
        return call(class_name, part.name, **below, **settings)
    plan.parts |= {"kinds", "container"}
    asked: dict[str, Code] = {}
    for key in kind.conditions:
        if getattr(kind, key):
            asked[key] = function_of(getattr(kind, key), part, plan)
    for key in kind.values:
        asked[key] = value_of(getattr(kind, key), part, plan)
    seen = plan.visible(part)
    asked |= {key: Code(f"{seen[getattr(kind, key)]}.get") for key in kind.reads}
    asked |= {key: Code(f"{seen[getattr(kind, key)]}.set") for key in kind.puts}
    plan.parts |= {"variable"} if kind.reads or kind.puts else set()
    plan.parts |= {"same"} if kind.values else set()
    given = {
        "outcomes": {label: Code(f"Status.{meaning.upper()}") for label, meaning in kind.outcomes.items()},
        "exits": table(part.exits),
        "edges": table(part.edges),
        "asked": asked,
    }
    made = plan.kinds.made(part, kind)
    return call("Container", part.name, made, names, **{key: said for key, said in given.items() if said})


def _of_py_trees(part: Part, plan: Plan) -> tuple[str, dict[str, object]] | None:
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
            policy = Code(f"py_trees.common.ParallelPolicy.SuccessOnAll({again})")
            return "py_trees.composites.Parallel", {"policy": policy}
        case model.Retry(times=times):
            return "py_trees.decorators.Retry", {"num_failures": times}
        case model.Repeat(times=times):
            return "py_trees.decorators.Repeat", {"num_success": _FOREVER if times is None else times}
        case model.Timeout(seconds=seconds, child_first=True) if not plan.grip:
            return "py_trees.decorators.Timeout", {"duration": seconds}
        case model.Guard(if_=text) if not plan.codes:
            return "py_trees.decorators.EternalGuard", {"condition": function_of(text, part, plan)}
        case model.Invert():
            return "py_trees.decorators.Inverter", {}
        case model.Force(as_=forced):
            name = "FailureIsSuccess" if forced == "success" else "SuccessIsFailure"
            return f"py_trees.decorators.{name}", {}
    return None


def wrapped(part: Part, made: Items, inner: str, plan: Plan) -> list[tuple[str, Items]]:
    """Return (name, expression) of a node and of what stands around it for its variables and its precondition."""
    rows = [(inner, made)]
    if is_fresh(part):
        plan.parts |= {"scope", "variable"}
        cells = [Code(plan.variables[id(cell)]) for cell in part.scope.cells.values()]
        name = plan.identifiers.take(f"fresh_{inner}")
        rows.append((name, call("Scope", part.name, Code(rows[-1][0]), cells)))
    if part.node.precondition:
        plan.parts.add("precondition")
        test = function_of(part.node.precondition, part, plan, around=True)
        name = plan.identifiers.take(f"{inner}_if")
        rows.append((name, call("Precondition", part.name, Code(rows[-1][0]), test)))
    return rows


def table(edges: Edges) -> dict[str, dict[str, str]]:
    """Return edges as child -> `outcome` or `outcome.code` -> target."""
    rows: dict[str, dict[str, str]] = {}
    for (child, outcome, code), target in edges:
        rows.setdefault(child, {})[outcome if code is None else f"{outcome}.{code}"] = target
    return rows
