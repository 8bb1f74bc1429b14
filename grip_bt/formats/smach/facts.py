"""What a machine that is there as an object is made of."""

from __future__ import annotations

import inspect
from pathlib import Path
from types import CodeType, FunctionType, LambdaType
from typing import Any

from grip_bt import smach_compat
from grip_bt.formats.names import is_literal
from grip_bt.nodes.smach_construction import CONTAINERS, Construction
from grip_bt.nodes.smach_leaf import with_all_below
from grip_bt.nodes.stand_ins import name_of, stands_in

from .found import Child, ContainerInfo, Span, StateInfo, Value

MOST_ITEMS = 10_000
"""Of a range; they stand in the task one by one."""
_OWN = ("__", "add", "open", "close", "register_", "get_", "check_", "set_contained_state", "_currently")
"""How what a container is built by begins, and what is asked when it is built."""
_CALLBACKS = ("start", "transition", "termination")


def facts_of(
    state: Any, file: Path, seen: Construction | None = None, line: int = 1, stores: dict[int, Any] | None = None
) -> StateInfo:
    """Return what a state is, and what it holds.

    Args:
        file: where it is made, with `line`, if nothing says.
        seen: the construction that made it.
        stores: id of a userdata -> the container that has it.
    """
    stores = {} if stores is None else stores
    place, at = seen.places.get(id(state), ("", 0)) if seen is not None else ("", 0)
    span = Span(Path(place or file), at or line)
    kinds = [c.__name__ for c in type(state).__mro__ if c.__module__.startswith(("grip_bt.smach", "smach"))]
    unknown = getattr(state, "stands_for", "")
    said = {
        "kind": "" if unknown else next(iter(kinds), ""),
        "cls": unknown or type(state).__name__,
        "span": span,
        "outcomes": [str(o) for o in state.get_registered_outcomes()],
        "input_keys": [str(k) for k in state.get_registered_input_keys()],
        "output_keys": [str(k) for k in state.get_registered_output_keys()],
    }
    if isinstance(state, CONTAINERS):
        return _container(state, said, seen, stores)
    made = StateInfo(**said)
    if unknown:
        made.problem("partial", f"the class {unknown} isn't here: its outcomes are taken from its transitions")
    return made


def _container(found: Any, said: dict[str, Any], seen: Construction | None, stores: dict[int, Any]) -> ContainerInfo:
    overridden, reasons = _overridden(found), _reasons(found, stores)
    inconsistent = ""
    try:
        found.check_consistency()
    except Exception as error:  # noqa: BLE001 - whatever is wrong with it
        unasked = isinstance(found, smach_compat.Concurrence) or "execute" in overridden  # it runs all the same
        inconsistent = "" if unasked else str(error)
    transitions, remappings, constants = (
        getattr(found, f"_{n}", {}) for n in ("transitions", "remappings", "constants")
    )
    children = {}
    for label, state in found.get_children().items():
        inner = facts_of(state, said["span"].file, seen, said["span"].line, stores)
        place = seen.added.get((id(found), str(label))) if seen is not None else None
        children[str(label)] = Child(
            label=str(label),
            state=inner,
            transitions={str(k): None if v is None else str(v) for k, v in transitions.get(label, {}).items()},
            remapping={str(k): str(v) for k, v in dict(remappings.get(label) or {}).items()},
            constants=[str(k) for k in constants.get(label, ())],
            span=inner.span if place is None else Span(Path(place[0]), place[1]),
        )
    made = ContainerInfo(
        **said,
        added=children,
        initial=None if (label := getattr(found, "_initial_state_label", None)) is None else str(label),
        userdata={str(k): literal(v) for k, v in found.userdata._data.items()},
        settings=_settings(found) | {n: v for n, v in (("overridden", overridden), ("asked", _asked(found))) if v},
        items=literal(_items(found._items)) if isinstance(found, smach_compat.Iterator) else None,
    )
    for reason in reasons:
        made.problem("partial", reason)
    if inconsistent:
        made.problem("failed", f"SMACH refuses it: {inconsistent}")
    return made


def _overridden(found: Any) -> list[str]:
    base = next(c for c in type(found).__mro__ if c in CONTAINERS)
    names = {n for c in type(found).__mro__[: type(found).__mro__.index(base)] for n in vars(c)}
    names |= {n for n, v in vars(found).items() if callable(v)}
    return sorted(n for n in names if n in dir(base) and not n.startswith(_OWN))


def _reasons(found: Any, stores: dict[int, Any]) -> list[str]:
    called = [f"its {k} callbacks aren't called by the task" for k in _CALLBACKS if getattr(found, f"_{k}_cbs", None)]
    if stores.setdefault(id(found.userdata), found) is not found:
        called.append("its userdata is also another container's: SMACH shares that store, the task copies its keys")
    return called


_SETTINGS = (
    *("default_outcome", "outcome_map", "outcome_cb", "child_termination_cb"),
    *("items_label", "exhausted_outcome", "loop_outcomes", "break_outcomes", "final_outcome_map"),
)


def _settings(found: Any) -> dict[str, Any]:
    said = {name: vars(found)[f"_{name}"] for name in _SETTINGS if f"_{name}" in vars(found)}
    return {name: value is not None if name.endswith("_cb") else value for name, value in said.items()}


def _asked(found: Any) -> list[str]:
    """Return keys that change here, and for which functions of items inside ask this container itself."""
    maps, keys, names = getattr(found, "_remappings", {}), {*found.get_registered_input_keys()}, set[str]()
    for label, state in found.get_children().items():
        keys |= {dict(maps.get(label) or {}).get(key, key) for key in state.get_registered_output_keys()}
    for items in (each._items for each in with_all_below(found) if isinstance(each, smach_compat.Iterator)):
        if isinstance(function := getattr(items, "__func__", items), FunctionType):
            seen, codes = inspect.getclosurevars(function), [function.__code__]
            near = [getattr(items, "__self__", None), *seen.nonlocals.values(), *seen.globals.values()]
            near += [part for each in near for part in getattr(each, "__dict__", {}).values()]
            for code in codes if any(each is found for each in near) else ():
                own = (getattr(getattr(type(found), each, None), "__code__", None) for each in code.co_names)
                codes += [each for each in (*code.co_consts, *own) if isinstance(each, CodeType) and each not in codes]
                names |= {each for each in (*code.co_names, *code.co_consts) if isinstance(each, str)}
    return sorted(keys & names)


def _items(items: Any) -> Any:
    """Return items; those of a lambda that names nothing but a range or a list are what it returns."""
    if not isinstance(items, LambdaType) or items.__code__.co_freevars:
        return items
    names = set(items.__code__.co_names) - {"range", "list", "__grip_call__"}
    if names or items.__code__.co_argcount:
        return items
    made = items()
    return list(made) if isinstance(made, range) and len(made) <= MOST_ITEMS else made


def literal(value: object) -> Value:
    """Return a value where JSON holds just that."""
    plain = list(value) if isinstance(value, range) and len(value) <= MOST_ITEMS else value
    if stands_in(plain):
        return Value(opaque=name_of(plain))
    return Value(value=plain) if is_literal(plain) else Value(opaque=type(value).__name__)
