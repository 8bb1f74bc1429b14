"""Variables: their types, their names, what is bound to them."""

from __future__ import annotations

from grip_bt.base.errors import listing, nearest
from grip_bt.task import Leaf, Subtask, Variable
from grip_bt.task.catalog import InputPort, OutputPort, Type, check_value, is_assignable, parse_type

from ..known import Known
from ..survey import Declared, Spot, Survey
from ..wording import has_literals, made_by, take_hint

_PORTED = (Leaf, Subtask)


def check_variables(survey: Survey) -> None:
    """Find wrong types, shadowed and never read variables, and ports bound to nothing or to another type."""
    for declared in survey.declared:
        _declaration(survey, declared)
    _shadowed(survey)
    for spot in survey.spots:
        if isinstance(spot.node, _PORTED):
            manifest = spot.manifest
            if spot.known is not None and _bound_alike(spot, spot.known, spot.node):
                continue
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


def _bound_alike(spot: Spot, known: Known, node: Leaf | Subtask) -> bool:
    """Tell whether every port is bound to a variable of the port's very type; most are."""
    scope = spot.scope
    for bound, types in ((node.in_, known.inputs), (node.out, known.outputs)):
        for port, name in bound.items():
            if name not in scope or port not in types or scope[name].type is not types[port]:
                return False
    return True


def _items(survey: Survey, spot: Spot, key: str, items: str) -> None:
    declared = spot.scope.get(items)
    if declared is None:
        hint = nearest(items, spot.scope)
        survey.add(
            spot.path,
            key,
            "undeclared-variable",
            f"`{key}` names {items!r}, which isn't declared{hint} (there are: {listing(spot.scope)})",
            take_hint(hint, f"declare it: `data: {{{items}: list[...]}}` in an enclosing container"),
        )
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
    if has_literals(type_):
        return f"give a literal of type {type_}, or {written}"
    return f"no literal is a {type_.name}: {written}{made_by(survey.catalog, type_)}"


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
        hint = nearest(name, spot.scope)
        new = f"declare it: `data: {{{name}: {port.type if port else 'Any'}}}` in this or an enclosing container"
        survey.add(
            spot.path,
            where,
            "undeclared-variable",
            f"the port {where[1]!r} is bound to {name!r}, which isn't declared{hint} "
            f"(there are: {listing(spot.scope)})",
            take_hint(hint, new),
        )
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
