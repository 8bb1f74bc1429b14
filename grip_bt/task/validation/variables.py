"""Variables: their types, their names, what is bound to them, and who writes them at once."""

from __future__ import annotations

from grip_bt.base.errors import listing, nearest
from grip_bt.task import Leaf, Parallel, Subtask, Variable
from grip_bt.task.catalog import InputPort, OutputPort, Type, check_value, is_assignable, parse_type

from .codes import has_literal_form, producers
from .outcomes import check_label, unknown_target
from .survey import Declared, Key, Spot, Survey

_PORTED = (Leaf, Subtask)


def check_variables(survey: Survey) -> None:
    """Find wrong types, shadowed and never read variables, and ports bound to nothing or to another type."""
    for declared in survey.declared:
        _declaration(survey, declared)
    _shadowed(survey)
    for spot in survey.spots:
        if isinstance(spot.node, _PORTED):
            manifest = spot.manifest
            for port, name in spot.node.in_.items():
                reads = manifest.inputs.get(port) if manifest else None
                _binding(survey, spot, ("in", port), name, reads)
            for port, name in spot.node.out.items():
                writes = manifest.outputs.get(port) if manifest else None
                _binding(survey, spot, ("out", port), name, writes)
        else:
            for key, items, _ in spot.node.taken():
                _items(survey, spot, key, items)
    read, written = survey.root.reads, survey.root.writes
    for declared in survey.declared:
        if not declared.bit & read and not (declared.owner == "" and declared.name in survey.task.outputs):
            what = "written but never read" if declared.bit & written else "never used"
            survey.add(
                declared.owner,
                (declared.key, declared.name),
                "never-read",
                f"the {'input' if declared.key == 'inputs' else 'variable'} {declared.name!r} is {what}",
                "remove it, or bind it under `in` of the node that needs it",
            )


def _items(survey: Survey, spot: Spot, key: str, items: str) -> None:
    declared = spot.scope.get(items)
    if declared is None:
        message = f"`{key}` names {items!r}, which isn't declared"
        new = f"declare it: `data: {{{items}: list[...]}}` in an enclosing container"
        survey.unknown(spot.path, key, "undeclared-variable", message, items, spot.scope, new)
    elif declared.type is not None and (declared.type.name not in ("list", "Any") or declared.type.optional):
        survey.add(
            spot.path,
            key,
            "wrong-variable-type",
            f"`{key}` takes a list, but {items!r} holds {declared.type}",
            f"name a variable of type `list[{declared.type}]`",
        )


def _declaration(survey: Survey, declared: Declared) -> None:
    where = (declared.key, declared.name)
    try:
        type_ = parse_type(declared.type_text)
    except ValueError as error:
        survey.add(declared.owner, where, "unknown-type", f"{declared.name!r}: {error}")
        return
    if isinstance(declared.variable, Variable) and declared.has_value:
        reason = check_value(type_, declared.variable.value)
        if reason:
            survey.add(
                declared.owner,
                (*where, "value"),
                "wrong-initial-value",
                f"the initial value of {declared.name!r} {reason}",
                _instead(survey, type_),
            )


def _instead(survey: Survey, type_: Type) -> str:
    """Return what to do in place of a wrong initial value: values that YAML can't write are made by nodes."""
    written = "leave `value` out and write the variable first"
    if has_literal_form(type_):
        return f"give a literal of type {type_}, or {written}"
    return f"no literal is a {type_.name}: {written}{producers(survey.catalog, type_)}"


def _shadowed(survey: Survey) -> None:
    for spot in survey.spots:
        if isinstance(spot.node, _PORTED):
            continue
        outer = spot.parent.scope if spot.parent is not None else survey.task_scope
        keys = {item: key for key, item in zip(spot.node.puts, (item for _, _, item in spot.node.taken()), strict=True)}
        for name in (*spot.node.data, *keys):
            if name in outer:
                owner = outer[name].owner or "the task"
                survey.add(
                    spot.path,
                    keys.get(name, ("data", name)),
                    "shadowed-variable",
                    f"the variable {name!r} hides the one that {owner} declares",
                    "give it another name, or remove this declaration to share the outer one",
                )


def _binding(
    survey: Survey, spot: Spot, where: tuple[str, str], name: str, port: InputPort | OutputPort | None
) -> None:
    declared = spot.scope.get(name)
    if declared is None:
        message = f"the port {where[1]!r} is bound to {name!r}, which isn't declared"
        new = f"declare it: `data: {{{name}: {port.type if port else 'Any'}}}` in this or an enclosing container"
        survey.unknown(spot.path, where, "undeclared-variable", message, name, spot.scope, new)
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
        survey.add(
            spot.path,
            where,
            "wrong-variable-type",
            f"the port {where[1]!r} {verb} {wanted}, but {name!r} holds {held}",
            f"bind a variable of type {wanted}, or change {name!r} in {owner}",
        )


def check_parallel(survey: Survey) -> None:
    """Find variables that two children of a parallel write, or that one writes and another reads."""
    for spot in survey.containers:
        if isinstance(spot.node, Parallel):
            _rules(survey, spot, spot.node)
            if spot.node.order is None:
                _shared(survey, spot)


def _rules(survey: Survey, spot: Spot, node: Parallel) -> None:
    for name in node.wait_for if isinstance(node.wait_for, list) else ():
        _child(survey, spot, "wait_for", name)
    for number, rule in enumerate(node.rules):
        where = ("rules", number)
        if rule.then not in spot.outcomes:
            unknown_target(survey, spot.path, (*where, "then"), rule.then, spot.outcomes, "outcomes of this container")
        for name, said in rule.when.items():
            child = _child(survey, spot, (*where, "when", name), name)
            for label in [said] if isinstance(said, str) else said:
                if child is not None:
                    check_label(survey, spot.path, (*where, "when", name), child, label)


def _child(survey: Survey, spot: Spot, where: Key, name: str) -> Spot | None:
    child = spot.children.get(name)
    if child is None:
        hint = nearest(name, spot.children)
        survey.add(
            spot.path, where, "unknown-child", f"{name!r} is no child{hint} (available: {listing(spot.children)})"
        )
    return child


def _shared(survey: Survey, spot: Spot) -> None:
    children = list(spot.children.values())
    written = read = twice = mixed = 0
    for child in children:
        twice |= written & child.writes
        mixed |= (written & child.reads) | (read & child.writes)
        written |= child.writes
        read |= child.reads
    for declared in survey.declared:
        if declared.bit & twice:
            writers = [c.name for c in children if c.writes & declared.bit]
            survey.add(
                spot.path,
                "children",
                "parallel-writes",
                f"the children {', '.join(writers)} write {declared.name!r} at the same time",
                "give each a variable of its own, or say `order: declared`",
            )
        elif declared.bit & mixed:
            writer = next(c.name for c in children if c.writes & declared.bit)
            reader = next(c.name for c in children if c.reads & declared.bit and c.name != writer)
            survey.add(
                spot.path,
                "children",
                "parallel-read-write",
                f"{reader!r} reads {declared.name!r} while {writer!r} writes it",
                f"read another variable, put {writer!r} before the parallel, or say `order: declared`",
            )
