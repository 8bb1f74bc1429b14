"""Variables: their types, their names, and what is bound to them."""

from __future__ import annotations

from grip_bt.task import Foreign, Leaf, Subtask, Variable
from grip_bt.task.catalog import InputPort, OutputPort, Type, check_value, is_assignable, parse_type
from grip_bt.task.parts import type_of

from .analysis import PlacedNode, TaskAnalysis, VariableDeclaration
from .codes import has_literal_form

_PORTED = (Leaf, Subtask, Foreign)


def check_variables(analysis: TaskAnalysis) -> None:
    """Find wrong types, shadowed and never read variables, and ports bound to nothing or to another type."""
    for declared in analysis.declared:
        _declaration(analysis, declared)
    _shadowed(analysis)
    for placed in analysis.nodes:
        if isinstance(placed.node, _PORTED):
            manifest = placed.manifest
            for port, name in placed.node.in_.items():
                reads = manifest.inputs.get(port) if manifest else None
                _binding(analysis, placed, ("in", port), name, reads)
            for port, name in placed.node.out.items():
                writes = manifest.outputs.get(port) if manifest else None
                _binding(analysis, placed, ("out", port), name, writes)
        else:
            for key, items, _ in placed.node.taken():
                _items(analysis, placed, key, items)
    read, written = analysis.root.reads, analysis.root.writes
    for declared in analysis.declared:
        if not declared.bit & read and not (declared.owner == "" and declared.name in analysis.task.outputs):
            what = "written but never read" if declared.bit & written else "never used"
            message = f"the {'input' if declared.key == 'inputs' else 'variable'} {declared.name!r} is {what}"
            fix = "remove it, or bind it under `in` of the node that needs it"
            analysis.add(declared.owner, (declared.key, declared.name), "never-read", message, fix)


def _items(analysis: TaskAnalysis, placed: PlacedNode, key: str, items: str) -> None:
    declared = placed.scope.get(items)
    if declared is None:
        message = f"`{key}` names {items!r}, which isn't declared"
        new = f"declare it: `data: {{{items}: list[...]}}` in an enclosing container"
        analysis.unknown(placed.path, key, "undeclared-variable", message, items, placed.scope, new)
    elif declared.type is not None and (declared.type.name not in ("list", "Any") or declared.type.optional):
        message = f"`{key}` takes a list, but {items!r} holds {declared.type}"
        fix = f"name a variable of type `list[{declared.type}]`"
        analysis.add(placed.path, key, "wrong-variable-type", message, fix)


def _declaration(analysis: TaskAnalysis, declared: VariableDeclaration) -> None:
    where = (declared.key, declared.name)
    try:
        type_ = parse_type(type_of(declared.variable))
    except ValueError as error:
        analysis.add(declared.owner, where, "unknown-type", f"{declared.name!r}: {error}")
        return
    if isinstance(declared.variable, Variable) and declared.variable.has_value:
        reason = check_value(type_, declared.variable.value)
        if reason:
            message = f"the initial value of {declared.name!r} {reason}"
            analysis.add(declared.owner, (*where, "value"), "wrong-initial-value", message, _instead(type_))


def _instead(type_: Type) -> str:
    """Return what to do in place of a wrong initial value: values that YAML can't write are made by nodes."""
    written = "leave `value` out and write the variable first"
    if has_literal_form(type_):
        return f"give a literal of type {type_}, or {written}"
    return f"no literal is a {type_.name}: {written}"


def _shadowed(analysis: TaskAnalysis) -> None:
    for placed in analysis.nodes:
        if isinstance(placed.node, _PORTED):
            continue
        outer = placed.parent.scope if placed.parent is not None else analysis.task_scope
        keys = {
            item: key for key, item in zip(placed.node.puts, (item for _, _, item in placed.node.taken()), strict=True)
        }
        for name in (*placed.node.data, *keys):
            if name in outer:
                owner = outer[name].owner or "the task"
                message = f"the variable {name!r} hides the one that {owner} declares"
                fix = "give it another name, or remove this declaration to share the outer one"
                analysis.add(placed.path, keys.get(name, ("data", name)), "shadowed-variable", message, fix)


def _binding(
    analysis: TaskAnalysis, placed: PlacedNode, where: tuple[str, str], name: str, port: InputPort | OutputPort | None
) -> None:
    declared = placed.scope.get(name)
    if declared is None:
        message = f"the port {where[1]!r} is bound to {name!r}, which isn't declared"
        new = f"declare it: `data: {{{name}: {port.type if port else 'Any'}}}` in this or an enclosing container"
        analysis.unknown(placed.path, where, "undeclared-variable", message, name, placed.scope, new)
        return
    if port is None or declared.type is None:
        return
    wanted, held = parse_type(port.type), declared.type
    if isinstance(port, InputPort):
        fits, verb = is_assignable(held, wanted), "reads"
    else:
        fits, verb = is_assignable(wanted, held), "writes"
    if not fits:
        owner = f"`{declared.key}` of {declared.owner or 'the task'}"
        message = f"the port {where[1]!r} {verb} {wanted}, but {name!r} holds {held}"
        fix = f"bind a variable of type {wanted}, or change {name!r} in {owner}"
        analysis.add(placed.path, where, "wrong-variable-type", message, fix)
