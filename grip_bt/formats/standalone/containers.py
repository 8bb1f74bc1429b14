"""How the file makes each container: with py_trees' own class where it does the same, else with a supporting one."""

from __future__ import annotations

from typing import Any

from grip_bt.base.errors import NotExpressibleError
from grip_bt.compilers.resolve import Part
from grip_bt.formats.expressible import require_expressible
from grip_bt.formats.python_source import Code, Items, call
from grip_bt.task import model, walking
from grip_bt.task.edges import Edges

from .leaves import function_of, value_of
from .plan import TARGET, Plan, is_fresh

_FOREVER = -1
"""What py_trees' Repeat takes for a number without limit."""


def container(part: Part, children: list[str], plan: Plan) -> Items:
    """Return the expression that makes a container of nodes that were made before it.

    Args:
        part: the container.
        children: names of its children in the file.
        plan: told what else is needed.
    """
    if isinstance(part.node, model.Parallel):
        return _parallel(part, children, plan)
    if isinstance(part.node, model.StateMachine):
        plan.parts.add("dispatch")
        return call(
            "Dispatch",
            part.name,
            children=_names(children),
            initial=part.node.initial,
            edges=table(part.edges),
            outcomes=_statuses(part, part.edges),
        )
    class_name, given = chooser(part, children, plan) or _plain(part, children, plan)
    if part.exits:
        plan.parts.add("exits")
        base, class_name = class_name, f"{class_name.rsplit('.', 1)[-1]}WithExits"
        plan.exits_classes[class_name] = base
        given |= {"exits": table(part.exits), "outcomes": _statuses(part, part.exits)}
    return call(class_name, part.name, **given)


def _plain(part: Part, children: list[str], plan: Plan) -> tuple[str, dict[str, Any]]:
    class_name, settings = _class_of(part, plan)
    if isinstance(part.node, model.Sequence | model.Fallback):
        return class_name, {**settings, "children": _names(children)}
    return class_name, {"child": Code(children[0]), **settings}


def _class_of(part: Part, plan: Plan) -> tuple[str, dict[str, Any]]:
    match part.node:
        case model.Sequence(memory=memory):
            return "py_trees.composites.Sequence", {"memory": memory}
        case model.Fallback(memory=memory):
            return "py_trees.composites.Selector", {"memory": memory}
        case model.Retry(times=times):
            return "py_trees.decorators.Retry", {"num_failures": times}
        case model.Repeat(times=times):
            return "py_trees.decorators.Repeat", {"num_success": _FOREVER if times is None else times}
        case model.Timeout(seconds=seconds, child_first=child_first):
            if child_first and not plan.grip:
                return "py_trees.decorators.Timeout", {"duration": seconds}
            plan.parts.add("timeout")
            return "Timeout", {"duration": seconds, **({"child_first": True} if child_first else {})}
        case model.Guard(if_=text):
            if plan.codes:
                plan.parts.add("guard")
            name = "Guard" if plan.codes else "py_trees.decorators.EternalGuard"
            return name, {"condition": function_of(text, part, plan)}
        case model.Invert():
            return "py_trees.decorators.Inverter", {}
        case model.Force(as_=forced):
            name = "FailureIsSuccess" if forced == "success" else "SuccessIsFailure"
            return f"py_trees.decorators.{name}", {}
    raise NotExpressibleError(part.path, f"a {type(part.node).__name__}", TARGET)


def _parallel(part: Part, children: list[str], plan: Plan) -> Items:
    node = part.node
    assert isinstance(node, model.Parallel)
    plain = not (part.exits or node.rules) and node.wait_for is None
    if plain and node.policy == "all" and node.cancel == "halt":
        again = "synchronise=False" if node.retick else ""
        policy = Code(f"py_trees.common.ParallelPolicy.SuccessOnAll({again})")
        return call("py_trees.composites.Parallel", part.name, policy=policy, children=_names(children))
    if node.retick:
        raise NotExpressibleError(part.path, "`retick` of a parallel with exits, rules or another policy", TARGET)
    plan.parts.add("parallel")
    given: dict[str, Any] = {
        "children": _names(children),
        "policy": node.policy,
        "join": node.cancel == "join",
        "exits": table(part.exits),
        "outcomes": _statuses(part, part.exits, *(rule.then for rule in node.rules)),
    }
    if not node.rules and node.wait_for is None:
        return call("Parallel", part.name, **given)
    plan.parts.add("ruled_parallel")
    waits = node.wait_for if isinstance(node.wait_for, str | int | None) else list(node.wait_for)
    return call("RuledParallel", part.name, **given, rules=[_rule(rule) for rule in node.rules], wait_for=waits)


def _rule(rule: model.ParallelRule) -> dict[str, Any]:
    when = {child: [said] if isinstance(said, str) else list(said) for child, said in rule.when.items()}
    counts = {} if rule.at_least is None else {"at_least": rule.at_least, "ends": rule.ends}
    return {**({"when": when} if when else {}), **counts, "then": rule.then}


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


def _statuses(part: Part, edges: Edges, *more: str) -> dict[str, Code]:
    targets = {*(target for _, target in edges), *more}
    children = {child.name for child in part.children} if isinstance(part.node, model.StateMachine) else set()
    used = [label for label in part.meaning if label in targets - children]
    return {label: Code(f"Status.{part.meaning[label].upper()}") for label in used}


def _names(children: list[str]) -> list[Code]:
    return [Code(name) for name in children]


def chooser(part: Part, children: list[str], plan: Plan) -> tuple[str, dict[str, Any]] | None:
    """Return class and arguments of a container that chooses; None for every other."""
    node = part.node
    match node:
        case model.Switch(on_value=text, default=default):
            cases: dict[str, list[Any]] = {}
            for child, literal in node.literals():
                cases.setdefault(child, []).append(literal)
            value = value_of(text, part, plan)
            made = "switch", "Switch", {"value": value, "cases": cases, "default": default}
        case model.Loop(while_=text, times=times):
            holds = function_of(text, part, plan) if text else None
            made = "loop", "Loop", {"condition": holds, "times": times}
        case model.ForEach(items=items, item=item):
            seen = plan.visible(part)
            plan.parts.add("variable")
            made = "for_each", "ForEach", {"items": Code(seen[items]), "item": Code(seen[item])}
        case model.Cooldown(seconds=seconds):
            made = "cooldown", "Cooldown", {"seconds": seconds}
        case _:
            return None
    name, class_name, arguments = made
    plan.parts |= {"chooser", name}
    names = [Code(child) for child in children]
    over = {"children": names} if isinstance(node, model.Switch) else {"child": names[0]}
    return class_name, {**over, **arguments}


_COMMON = {"doc", "precondition", "on", "x"}
_CONTAINER = {*_COMMON, "kind", "data", "outcomes"}
_KNOWN: dict[type[Any], set[str]] = {
    model.Leaf: {*_COMMON, "node", "with_", "in_", "out", "meaning"},
    model.Sequence: {*_CONTAINER, "children", "exits", "memory"},
    model.Fallback: {*_CONTAINER, "children", "exits", "memory"},
    model.Parallel: {*_CONTAINER, "children", "exits", "policy", "cancel", "order", "rules", "wait_for", "retick"},
    model.Switch: {*_CONTAINER, "children", "exits", "on_value", "cases", "default"},
    model.ForEach: {*_CONTAINER, "child", "exits", "items", "item"},
    model.Loop: {*_CONTAINER, "child", "exits", "while_", "times"},
    model.Cooldown: {*_CONTAINER, "child", "exits", "seconds"},
    model.StateMachine: {*_CONTAINER, "initial", "children"},
    model.Retry: {*_CONTAINER, "child", "exits", "times"},
    model.Repeat: {*_CONTAINER, "child", "exits", "times"},
    model.Timeout: {*_CONTAINER, "child", "exits", "seconds", "child_first"},
    model.Guard: {*_CONTAINER, "child", "exits", "if_"},
    model.Foreign: {*_COMMON, "kind", "behaviour", "args"},
    model.Invert: {*_CONTAINER, "child", "exits"},
    model.Force: {*_CONTAINER, "child", "exits", "as_"},
}


def refuse_unknown(task: model.Task) -> None:
    """Refuse kinds of nodes, and settings of them, that this export has no words for.

    Raises:
        NotExpressibleError: for the first one.
    """
    for path, node in walking.walk(task.root):
        require_expressible(path, node, _KNOWN, TARGET)
        if getattr(node, "cancel", "halt") not in ("halt", "join"):
            raise NotExpressibleError(path, f"`cancel: {getattr(node, 'cancel', '')}` of a parallel", TARGET)
