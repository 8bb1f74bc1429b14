"""Tasks of the first GRIP in its text form: nested YAML whose parameters are handed down by `params:`."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError

from grip_bt.base.errors import GripError, nearest
from grip_bt.formats.names import free, key_of, node_name
from grip_bt.task.model import Meaning


@dataclass
class GripState:
    """One state; its type is a class, a component, a sensor or a state of the user's.

    The first of its outcomes is the good one, the last the bad one; each leads to a state or outcome of the container.
    `reads` and `writes` are keys of the userdata, where the file names them.
    """

    name: str
    type: str
    slots: dict[str, Any] = field(default_factory=dict)
    outcomes: list[str] = field(default_factory=list)
    leads: dict[str, str] = field(default_factory=dict)
    reads: list[str] = field(default_factory=list)
    writes: list[str] = field(default_factory=list)


@dataclass
class GripContainer(GripState):
    """A container; `outcomes` are its own, `leads` say where these go in its parent.

    Of a concurrent one, `rules` are outcome -> child -> the outcome that it must have; `default` where none holds.
    """

    concurrent: bool = False
    children: dict[str, GripState] = field(default_factory=dict)
    initial: str = ""
    default: str = ""
    rules: dict[str, dict[str, str]] = field(default_factory=dict)

    def states(self) -> Iterator[GripState]:
        """Yield every state below, containers not."""
        for child in self.children.values():
            if isinstance(child, GripContainer):
                yield from child.states()
            else:
                yield child


_GOOD = ("succ", "suces")
_BAD = ("fail", "abort", "error", "none", "preempt", "quit", "unsucc")


def name_of(label: str, taken: Collection[str] = ()) -> str:
    """Return a label as a task may spell it, none of those that are taken."""
    return free(node_name(label), taken)


def outcome_meanings(outcomes: Sequence[str]) -> dict[str, Meaning]:
    """Return what outcomes mean: by their names; else the first is good, and the last of several bad."""
    found: dict[str, Meaning] = {}
    for number, outcome in enumerate(outcomes):
        bad, good = (any(word in outcome.lower() for word in words) for words in (_BAD, _GOOD))
        last = number == len(outcomes) - 1 and number > 0
        found[outcome] = "failure" if bad or (last and not good) else "success"
    return found


def is_hand(group: str) -> bool:
    """Tell whether a group of joints is a hand, by its name."""
    return any(word in group.lower() for word in ("hand", "gripper", "finger")) and "arm" not in group.lower()


class BrokenTaskError(GripError):
    """A task of the first GRIP can't be read; the message says what and where."""


@contextmanager
def broken_if_invalid(place: str) -> Iterator[None]:
    """Say in words what pydantic says of data."""
    try:
        yield
    except ValidationError as error:
        first = error.errors()[0]
        raise BrokenTaskError(f"{place}: {'/'.join(map(str, first['loc']))}: {first['msg']}") from None


DEEPEST = 30
"""Most containers that may lie in each other."""
CONCURRENT = "concurrent_state_machine"
_CONTAINERS = {CONCURRENT, "framework_state_machine", "state_machine", "sm_base"}
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
_Scope = ChainMap[str, Any]


class _Said(BaseModel):
    """What is said of a state or container; anything else of it is a slot."""

    model_config = ConfigDict(extra="allow", coerce_numbers_to_str=True)
    name: str = ""
    source: str = ""
    outcomes: list[str] = []
    transitions: dict[str, str] = {}
    input_keys: list[str] = []
    output_keys: list[str] = []
    io_keys: list[str] = []
    initial: str = ""
    default_outcome: str = ""
    outcome_map: dict[str, dict[str, str]] = {}


def text_task(data: object, source: str) -> GripContainer:
    """Return the task that a nested dictionary holds. Raises BrokenTaskError: it holds none, or is broken."""
    if not isinstance(data, Mapping) or "states" not in data:
        raise BrokenTaskError(f"{source}: there is no task in it: `name`, `outcomes` and `states` are expected")
    return _container(str(data.get("name") or "task"), data, ChainMap(), source, 0)


def _said(data: Mapping[str, Any], scope: _Scope, place: str) -> tuple[_Said, _Scope]:
    """Return what is said, and what stands for `params.NAME` in it and below: its own `params` are said of it too."""

    def value(said: Any, around: _Scope) -> Any:
        if isinstance(said, list):
            return [value(each, around) for each in said]
        if not isinstance(said, str) or not said.startswith("params."):
            return said
        name = said.removeprefix("params.")
        if name not in around:
            known = f"{nearest(name, around)} (available: {', '.join(sorted(around)) or 'none'})"
            raise BrokenTaskError(f"{place}: no `params` here or around it has {name!r}{known}")
        return around[name]

    own = data.get("params") or {}
    if not isinstance(own, Mapping):
        raise BrokenTaskError(f"{place}: `params` is a mapping from names to values")
    inner = scope.new_child({str(name): value(each, scope) for name, each in own.items()})
    rest = {str(n): value(each, inner) for n, each in data.items() if n not in ("params", "states")}
    with broken_if_invalid(place):
        return _Said.model_validate({n: v for n, v in {**inner.maps[0], **rest}.items() if v is not None}), inner


def _container(name: str, data: Mapping[str, Any], around: _Scope, place: str, depth: int) -> GripContainer:
    said, scope = _said(data, around, place)
    if depth > DEEPEST:
        raise BrokenTaskError(f"{place}: containers lie in each other more than {DEEPEST} deep")
    made = GripContainer(name, said.source, outcomes=said.outcomes or list(said.transitions) or ["success", "fail"])
    made.concurrent, made.leads = said.source == CONCURRENT, said.transitions
    states = data.get("states")
    if not isinstance(states, list) or not states:
        raise BrokenTaskError(f"{place}: `states` is a list of states and not empty")
    for entry in states:
        if not isinstance(entry, Mapping) or len(entry) != 1:
            raise BrokenTaskError(f"{place}: a state is `NAME: {{source: ..., ...}}`, not {str(entry)[:60]}")
        ((label, inner),) = entry.items()
        if not isinstance(inner, Mapping):
            raise BrokenTaskError(f"{place}/{label}: a mapping with `source` is expected")
        if str(label) in made.children:
            raise BrokenTaskError(f"{place}/{label}: two states have this name")
        made.children[str(label)] = _child(str(label), inner, scope, f"{place}/{label}", depth)
    made.initial, made.default = said.initial or next(iter(made.children)), said.default_outcome or made.outcomes[-1]
    made.rules = said.outcome_map
    for outcome in (made.default, *made.rules) if made.concurrent else ():
        if outcome not in made.outcomes:
            known = f"{nearest(outcome, made.outcomes)} (available: {', '.join(made.outcomes)})"
            raise BrokenTaskError(f"{place}: it may end with {outcome!r}, which is none of its outcomes{known}")
    return made


def _child(label: str, data: Mapping[str, Any], scope: _Scope, place: str, depth: int) -> GripState:
    said, _ = _said(data, scope, place)
    if said.source in _CONTAINERS or data.get("states") is not None:
        return _container(label, data, scope, place, depth + 1)
    kind = _TYPES.get(said.source.removeprefix("state_"), said.source)
    usual = ["success", "fail"] if kind in (*_TYPES.values(), "") else ["success", "failure"]
    made = GripState(label, kind, {_SLOTS.get(n, n): value for n, value in (said.model_extra or {}).items()})
    made.outcomes, made.leads = (
        said.outcomes or list(said.transitions) or (["success", "finished"] if kind == "Counter" else usual),
        said.transitions,
    )
    made.reads, made.writes = said.input_keys + said.io_keys, said.output_keys + said.io_keys
    _as_in_the_editor(made)
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
