"""The text form of tasks, which came before the editor: nested YAML whose parameters are handed down by `params:`."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Mapping
from typing import Any

from grip_bt.base.errors import nearest
from grip_bt.formats.names import key_of

from .tasks import DEEPEST, OUTCOMES, BrokenTaskError, GripContainer, GripState

_CONTAINERS = {"concurrent_state_machine", "framework_state_machine", "state_machine", "sm_base"}
_NAMED = ("ComputePlan", "Move", "Counter", "Select", "WaitFor", "ExecuteTrajectory", "AllowCollisions")
_TYPES = {
    "plan": "ComputePlan",
    "allow_manipulator_collisions": "AllowCollisions",
    **{key_of(name): name for name in (*_NAMED, "ReinitialiseManagers", "Grasp", "WaitForSignal")},
}
_SLOTS = {
    "target_state_type": "target_type",
    "target_state_name": "target_name",
    "starting_state_type": "starting_type",
    "starting_state_name": "starting_name",
    "collision_type": "collision",
}
"""Parameter -> the slot of the editor that took its place."""
_KEYS = ("input_keys", "output_keys", "io_keys")
_Scope = ChainMap[str, Any]


def text_task(data: object, source: str) -> GripContainer:
    """Return the task that a nested dictionary holds. Raises BrokenTaskError: it holds none, or is broken."""
    if not isinstance(data, Mapping) or "states" not in data:
        raise BrokenTaskError(f"{source}: there is no task in it: `name`, `outcomes` and `states` are expected")
    return _container(str(data.get("name") or "task"), _Said(data, ChainMap(), source), 0)


class _Said:
    """What is said of a state or container.

    Its own `params` are parameters of it, and stand for `params.NAME` in it and, of a container, in all that is below.
    """

    def __init__(self, data: Mapping[str, Any], scope: _Scope, place: str):
        self.place = place
        own = data.get("params") or {}
        if not isinstance(own, Mapping):
            raise BrokenTaskError(f"{place}: `params` is a mapping from names to values")
        self.scope = scope.new_child({str(name): self._value(value, scope) for name, value in own.items()})
        rest = {str(name): value for name, value in data.items() if name not in ("params", "states")}
        self.states = data.get("states")
        self.parameters = {**self.scope.maps[0], **{n: self._value(value, self.scope) for n, value in rest.items()}}

    def _value(self, value: Any, scope: _Scope) -> Any:
        if isinstance(value, list):
            return [self._value(each, scope) for each in value]
        if not isinstance(value, str) or not value.startswith("params."):
            return value
        name = value.removeprefix("params.")
        if name not in scope:
            listed = ", ".join(sorted(scope)) or "none"
            raise BrokenTaskError(
                f"{self.place}: no `params` here or around it has {name!r}{nearest(name, scope)} (available: {listed})"
            )
        return scope[name]

    def names(self, key: str) -> list[str]:
        found = self.parameters.get(key) or []
        if not isinstance(found, list) or not all(isinstance(each, str | int) for each in found):
            raise BrokenTaskError(f"{self.place}: `{key}` is a list of names")
        return [str(each) for each in found]

    def mapping(self, key: str, what: str) -> Mapping[str, Any]:
        found = self.parameters.get(key) or {}
        if not isinstance(found, Mapping):
            raise BrokenTaskError(f"{self.place}: `{key}` is {what}")
        return found


def _container(name: str, said: _Said, depth: int) -> GripContainer:
    place = said.place
    if depth > DEEPEST:
        raise BrokenTaskError(f"{place}: containers lie in each other more than {DEEPEST} deep")
    outcomes = said.names("outcomes") or [str(each) for each in said.mapping("transitions", _LEADS)]
    made = GripContainer(name, str(said.parameters.get("source", "")), outcomes=outcomes or ["success", "fail"])
    made.concurrent = made.type == "concurrent_state_machine"
    if not isinstance(said.states, list) or not said.states:
        raise BrokenTaskError(f"{place}: `states` is a list of states and not empty")
    for entry in said.states:
        if not isinstance(entry, Mapping) or len(entry) != 1:
            raise BrokenTaskError(f"{place}: a state is `NAME: {{source: ..., ...}}`, not {str(entry)[:60]}")
        ((label, inner),) = entry.items()
        if not isinstance(inner, Mapping):
            raise BrokenTaskError(f"{place}/{label}: a mapping with `source` is expected")
        if str(label) in made.children:
            raise BrokenTaskError(f"{place}/{label}: two states have this name")
        made.children[str(label)] = _child(str(label), _Said(inner, said.scope, f"{place}/{label}"), depth)
    made.initial = str(said.parameters.get("initial") or next(iter(made.children)))
    if made.concurrent:
        _concurrent(made, said)
    return made


_LEADS = "a mapping from outcomes to states"


def _concurrent(made: GripContainer, said: _Said) -> None:
    rules = said.mapping("outcome_map", "outcome -> state -> outcome")
    if not all(isinstance(when, Mapping) for when in rules.values()):
        raise BrokenTaskError(f"{said.place}: `outcome_map` is outcome -> state -> outcome")
    made.default = str(said.parameters.get("default_outcome") or made.outcomes[-1])
    made.rules = {str(o): {str(child): [str(end)] for child, end in when.items()} for o, when in rules.items()}
    for outcome in (made.default, *made.rules):
        if outcome not in made.outcomes:
            raise BrokenTaskError(
                f"{said.place}: it may end with {outcome!r}, which is none of its outcomes"
                f"{nearest(outcome, made.outcomes)} (available: {', '.join(made.outcomes)})"
            )


def _child(label: str, said: _Said, depth: int) -> GripState:
    leads = said.mapping("transitions", _LEADS)
    source = str(said.parameters.get("source", ""))
    if source in _CONTAINERS or said.states is not None:
        made: GripState = _container(label, said, depth + 1)
    else:
        kind = _TYPES.get(source.removeprefix("state_"), source)
        usual = ["success", "fail"] if kind in (*_TYPES.values(), "") else ["success", "failure"]
        outcomes = said.names("outcomes") or [str(each) for each in leads] or OUTCOMES.get(kind, usual)
        left = ("source", "transitions", "outcomes", "name", *_KEYS)
        slots = {_SLOTS.get(name, name): value for name, value in said.parameters.items() if name not in left}
        both = said.names("io_keys")
        made = GripState(label, kind, slots, outcomes, reads=said.names("input_keys") + both)
        made.writes = said.names("output_keys") + both
        _as_in_the_editor(made)
    made.leads = {str(outcome): str(target) for outcome, target in leads.items()}
    return made


def _as_in_the_editor(state: GripState) -> None:
    """Say what a state reads and writes by slots, as the editor's states do.

    The text form had it in fixed keys of the userdata: `selected_grasp` for a grasp and its parts, `selected_pose` ...
    """
    slots = state.slots
    for which in ("target", "starting"):
        kind = str(slots.get(f"{which}_type") or "")
        if slots.get(f"{which}_name") == "userdata":
            slots[f"{which}_name"], slots[f"{which}_type"] = selected(kind), ""
            slots[f"{which}_part"] = kind if "grasp" in kind else ""
    if state.type == "Select" and "message_type" in slots:
        kind, names = str(slots.pop("message_type")), slots.pop("message_names", None)
        key = selected(kind)
        slots |= {"input_type": kind, "output": key if key in state.writes else "", "names": names}
    elif state.type == "Move" and "selected_plan" in state.reads:
        slots["plan_name"] = "selected_plan"


def selected(kind: str) -> str:
    """Return the key of the userdata for what was selected: grasps in whole, whichever part is wanted."""
    return f"selected_{'grasp' if 'grasp' in kind else kind.replace(' ', '_')}"
