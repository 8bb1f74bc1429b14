"""Tasks as the nested dictionaries of the first GRIP: its older text files, and what its generator was given."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .graphs import OUTCOMES, BrokenTaskError
from .original import OriginalContainer, OriginalState

_CONTAINERS = {"state_machine": False, "concurrent_state_machine": True, "sm_base": False}
_TYPES = {
    "plan": "ComputePlan",
    "compute_plan": "ComputePlan",
    "move": "Move",
    "counter": "Counter",
    "select": "Select",
    "wait_for": "WaitFor",
    "execute_trajectory": "ExecuteTrajectory",
    "allow_collisions": "AllowCollisions",
    "reinitialise_managers": "ReinitialiseManagers",
}
_DEEPEST = 30


def text_task(data: Any, source: str) -> OriginalContainer:
    """Return the task that a nested dictionary holds.

    Raises:
        BrokenTaskError: it holds none, or is broken.
    """
    if not isinstance(data, Mapping) or "states" not in data:
        raise BrokenTaskError(f"{source}: there is no task in it: `name`, `outcomes` and `states` are expected")
    return _container(str(data.get("name") or "task"), data, source, 0)


def _container(name: str, data: Mapping[str, Any], place: str, depth: int) -> OriginalContainer:
    if depth > _DEEPEST:
        raise BrokenTaskError(f"{place}: containers lie in each other more than {_DEEPEST} deep")
    outcomes = data.get("outcomes") or list(data.get("transitions") or {}) or ["success", "fail"]
    if not isinstance(outcomes, list) or not all(isinstance(each, str | int) for each in outcomes):
        raise BrokenTaskError(f"{place}: `outcomes` is a list of names")
    made = OriginalContainer(name, str(data.get("source", "")), outcomes=[str(each) for each in outcomes])
    made.concurrent = _CONTAINERS.get(made.type, False)
    states = data.get("states")
    if not isinstance(states, list) or not states:
        raise BrokenTaskError(f"{place}: `states` is a list of states and not empty")
    for entry in states:
        if not isinstance(entry, Mapping) or len(entry) != 1:
            raise BrokenTaskError(f"{place}: a state is `NAME: {{source: ..., ...}}`, not {str(entry)[:60]}")
        ((label, said),) = entry.items()
        inside = f"{place}/{label}"
        if not isinstance(said, Mapping):
            raise BrokenTaskError(f"{inside}: a mapping with `source` is expected")
        if str(label) in made.children:
            raise BrokenTaskError(f"{inside}: two states have this name")
        made.children[str(label)] = _child(str(label), said, inside, depth)
    made.initial = str(data.get("initial") or next(iter(made.children)))
    if made.concurrent:
        made.default = str(data.get("default_outcome") or made.outcomes[-1])
        made.rules = _rules(data.get("outcome_map") or {}, place)
    return made


def _child(label: str, said: Mapping[str, Any], place: str, depth: int) -> OriginalState:
    leads = said.get("transitions") or {}
    if not isinstance(leads, Mapping):
        raise BrokenTaskError(f"{place}: `transitions` is a mapping from outcomes to states")
    source = str(said.get("source", ""))
    if source in _CONTAINERS or "states" in said:
        made: OriginalState = _container(label, said, place, depth + 1)
    else:
        kind = _TYPES.get(source, source)
        rest = {str(k): v for k, v in said.items() if k not in ("source", "transitions", "outcomes")}
        outcomes = said.get("outcomes") or list(leads) or OUTCOMES.get(kind, ["success", "failure"])
        made = OriginalState(label, kind, rest, [str(each) for each in outcomes])
    made.leads = {str(outcome): str(target) for outcome, target in leads.items()}
    return made


def _rules(said: Any, place: str) -> dict[str, dict[str, list[str]]]:
    if not isinstance(said, Mapping) or not all(isinstance(when, Mapping) for when in said.values()):
        raise BrokenTaskError(f"{place}: `outcome_map` is outcome -> state -> outcome")
    return {str(o): {str(child): [str(end)] for child, end in when.items()} for o, when in said.items()}
