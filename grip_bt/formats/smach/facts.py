"""What a machine that is there as an object is made of, as JSON can tell it."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from types import LambdaType
from typing import Any

from pydantic import BaseModel, JsonValue

from grip_bt import smach_compat
from grip_bt.nodes.smach_construction import CONTAINERS, Construction
from grip_bt.nodes.stand_ins import UNKNOWN, name_of, stands_in, value_of

from .found import Child, ContainerInfo, Span, StateInfo, Unresolved

MOST_ITEMS = 10_000
"""Of a range; they stand in the task one by one."""
_OWN = (
    "__init__",
    "__module__",
    "__doc__",
    "__dict__",
    "__weakref__",
    "__qualname__",
    "__annotations__",
    "__init_subclass__",
)
_CALLBACKS = ("start", "transition", "termination")


class Value(BaseModel):
    """What JSON holds, or the class of what it doesn't: objects of subclasses, too."""

    value: JsonValue = None
    opaque: str | None = None

    def plain(self) -> object:
        """Return the value, or what stands for one that no file can hold."""
        return self.value if self.opaque is None else Unresolved(self.opaque)


class StateFacts(BaseModel):
    """A state as it was made."""

    cls: str
    kind: str
    file: str = ""
    line: int = 0
    outcomes: list[str]
    input_keys: list[str]
    output_keys: list[str]
    inside: ContainerFacts | None = None


class ChildFacts(BaseModel):
    """A state as it was added to a container."""

    label: str
    state: StateFacts
    transitions: dict[str, str | None]
    remapping: dict[str, str]
    constants: dict[str, Value]
    file: str = ""
    line: int = 0


class ContainerFacts(BaseModel):
    """What a container is besides a state; `items` are an Iterator's, `reasons` say what no task has."""

    children: list[ChildFacts]
    initial: str | None
    userdata: dict[str, Value]
    settings: dict[str, Any]
    items: Value | None = None
    reasons: list[str] = []
    inconsistent: str = ""


def facts_of(state: Any, seen: Construction | None = None, stores: dict[int, Any] | None = None) -> StateFacts:
    """Return what a state is, and what it holds; `seen`: the construction that made it."""
    stores = {} if stores is None else stores
    file, line = seen.places.get(id(state), ("", 0)) if seen is not None else ("", 0)
    kinds = [c.__name__ for c in type(state).__mro__ if c.__module__.startswith(("grip_bt.smach", "smach"))]
    unknown = getattr(state, "stands_for", "")
    return StateFacts(
        cls=unknown or type(state).__name__,
        kind="" if unknown else next(iter(kinds), ""),
        file=file,
        line=line,
        outcomes=[str(o) for o in state.get_registered_outcomes()],
        input_keys=[str(k) for k in state.get_registered_input_keys()],
        output_keys=[str(k) for k in state.get_registered_output_keys()],
        inside=_inside(state, seen, stores) if isinstance(state, CONTAINERS) else None,
    )


def _inside(found: Any, seen: Construction | None, stores: dict[int, Any]) -> ContainerFacts:
    reasons = _reasons(found, stores)
    inconsistent = ""
    try:
        found.check_consistency()
    except Exception as error:  # noqa: BLE001 - whatever is wrong with it
        inconsistent = "" if isinstance(found, smach_compat.Concurrence) else str(error)  # it is executed all the same
    transitions = getattr(found, "_transitions", {})
    remappings = getattr(found, "_remappings", {})
    constants = getattr(found, "_constants", {})
    children = [
        ChildFacts(
            label=str(label),
            state=facts_of(state, seen, stores),
            transitions={str(k): None if v is None else str(v) for k, v in transitions.get(label, {}).items()},
            remapping={str(k): str(v) for k, v in dict(remappings.get(label) or {}).items()},
            constants={str(k): literal(v) for k, v in constants.get(label, {}).items()},
            **_where_added(found, str(label), seen),
        )
        for label, state in found.get_children().items()
    ]
    return ContainerFacts(
        children=children,
        initial=getattr(found, "_initial_state_label", None),
        userdata={str(k): literal(v) for k, v in found.userdata._data.items()},
        settings=_settings(found),
        items=literal(_items(found._items)) if isinstance(found, smach_compat.Iterator) else None,
        reasons=reasons,
        inconsistent=inconsistent,
    )


def _where_added(found: Any, label: str, seen: Construction | None) -> dict[str, Any]:
    place = seen.added.get((id(found), label)) if seen is not None else None
    return {} if place is None else {"file": place[0], "line": place[1]}


def _reasons(found: Any, stores: dict[int, Any]) -> list[str]:
    base = next(c for c in type(found).__mro__ if c in CONTAINERS)
    overridden = {n for c in type(found).__mro__[: type(found).__mro__.index(base)] for n in vars(c)}
    overridden |= {n for n, v in vars(found).items() if callable(v) and n in dir(base)}
    names = sorted(n for n in overridden if n in dir(base) and n not in _OWN)
    reasons = [f"its class has a `{name}` of its own, which the task doesn't call" for name in names]
    called = [kind for kind in _CALLBACKS if getattr(found, f"_{kind}_cbs", None)]
    reasons += [f"its {kind} callbacks aren't called by the task" for kind in called]
    if stores.setdefault(id(found.userdata), found) is not found:
        reasons.append("its userdata is also another container's: SMACH shares that store, the task copies its keys")
    return reasons


def _settings(found: Any) -> dict[str, Any]:
    if isinstance(found, smach_compat.Concurrence):
        return {
            "default_outcome": found._default_outcome,
            "outcome_map": {k: dict(v) for k, v in found._outcome_map.items()},
            "outcome_cb": found._outcome_cb is not None,
            "child_termination_cb": found._child_termination_cb is not None,
        }
    if isinstance(found, smach_compat.Iterator):
        return {
            "it_label": found._items_label,
            "exhausted_outcome": found._exhausted_outcome,
            "loop_outcomes": list(found._loop_outcomes),
            "break_outcomes": list(found._break_outcomes),
            "final_outcome_map": dict(found._final_outcome_map),
        }
    return {}


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
    return Value(value=plain) if _is_plain(plain) else Value(opaque=type(value).__name__)


def _is_plain(value: object) -> bool:
    if type(value) is list:
        return all(map(_is_plain, value))
    if type(value) is dict:
        return all(type(key) is str and _is_plain(item) for key, item in value.items())
    return value is None or type(value) in (bool, int, str) or (type(value) is float and math.isfinite(value))


def unwrapped(value: Any, told: Callable[[str, Any], None]) -> Any:
    """Return a label, or a list or mapping of them, without stand-ins; `told` hears of each, and of what it holds."""
    if stands_in(value) and not isinstance(value, type):
        held = value_of(value)
        told(name_of(value), held)
        return f"<{name_of(value)}>" if held is UNKNOWN else held
    if isinstance(value, (list, tuple)):
        return [unwrapped(each, told) for each in value]
    if isinstance(value, dict) and any(stands_in(each) for pair in value.items() for each in pair):
        return {unwrapped(key, told): unwrapped(each, told) for key, each in value.items()}
    return value


def found_from(facts: StateFacts, file: Path, parent: ContainerInfo | None = None) -> StateInfo:
    """Return what was found, as an import goes on with it; `file`: where it is, if nothing says."""
    span = Span(Path(facts.file) if facts.file else file, facts.line or (parent.span.line if parent else 1))
    words = facts.outcomes, facts.input_keys, facts.output_keys
    if facts.inside is None:
        state = StateInfo(facts.kind, facts.cls, span, *words, parent=parent)
        if not facts.kind:
            state.problem("partial", f"the class {facts.cls} isn't here: its outcomes are taken from its transitions")
        return state
    inside = facts.inside
    made = ContainerInfo(facts.kind, facts.cls, span, *words, parent=parent, initial=inside.initial)
    made.settings = dict(inside.settings)
    for name in ("outcome_cb", "child_termination_cb"):
        if name in made.settings:
            made.settings[name] = Unresolved(name) if made.settings[name] else None
    if inside.items is not None:
        made.settings["it"] = inside.items.plain()
    made.userdata = {key: value.plain() for key, value in inside.userdata.items()}
    for reason in inside.reasons:
        made.problem("partial", reason)
    if inside.inconsistent:
        made.problem("failed", f"SMACH refuses it: {inside.inconsistent}")
    for child in inside.children:
        inner = found_from(child.state, file, made)
        constants = {key: value.plain() for key, value in child.constants.items()}
        place = Span(Path(child.file), child.line) if child.file else inner.span
        made.added[child.label] = Child(child.label, inner, child.transitions, child.remapping, place, constants)
    return made
