"""States of the first GRIP as nodes: its own, those of components and sensors, and those that nobody knows."""

from __future__ import annotations

import re
from typing import Any

from .original import OriginalState
from .states import STATES, moves_a_hand
from .steps import PLAIN, STORES, Made, Setting, Steps
from .words import key_of, name_of


def node_of(state: OriginalState, setting: Setting, place: str) -> Made:
    """Return a state as a node."""
    steps = Steps(state, setting, place)
    if state.type in STATES and not moves_a_hand(state):
        ends = STATES[state.type](steps)
        return Made(steps.node(), ends)
    if state.type in setting.components:
        return _component(steps)
    if state.type in setting.sensors:
        return Made(_sensor(steps), PLAIN)
    return _unknown(steps)


def _component(steps: Steps) -> Made:
    key, count = steps.setting.components[steps.state.type]
    given = {"input": _input(steps)} if steps.slot("input") else {}
    output, store = steps.slot("output"), STORES.get(steps.slot("output_type"), ("", ""))[0]
    returned = steps.setting.variable(output) if output else ""
    out = {"returned_object": returned} if returned else {}
    steps.add("call", f"component/{key}", in_=given, out=out)
    if store:
        steps.note("missing", f"its result went to the {store} as {output!r}; add `messages/put` after it")
    ends = {str(number): f"outcome_{number}" for number in range(count)} | {"state_failure": "failure"}
    if len(steps.steps) == 1:
        return Made(steps.node(), ends)
    exits = {f"call.outcome_{number}": f"outcome_{number}" for number in range(count)}
    outcomes = dict.fromkeys(exits.values(), "success")
    return Made({**steps.node(), "outcomes": outcomes, "exits": exits}, ends)


def _input(steps: Steps) -> str:
    """Return the variable of what a component is given: text in quotes and what isn't text are literals."""
    value = steps.state.slots["input"]
    if isinstance(value, str) and not re.fullmatch(r"\"[^\"]*\"", value.strip()):
        return steps.value(steps.slot("input"), steps.slot("input_type"), "the input")
    literal = value.strip()[1:-1] if isinstance(value, str) else value
    variable = steps.setting.variable(f"input_of_{steps.state.name}")
    steps.add("set_input", "flow/set", with_={"value": literal}, out={"value": variable})
    return variable


def _sensor(steps: Steps) -> dict[str, Any]:
    key, alias = steps.setting.sensors[steps.state.type], key_of(steps.slot("sensor_topic") or "data")
    out = {alias: steps.setting.variable(steps.slot("output"))} if steps.slot("output") else {}
    steps.add("look", f"sensor/{key}", out=out)
    return steps.node()


def _unknown(steps: Steps) -> Made:
    """Return a node of the project's own whose class has to be filled in."""
    state, setting = steps.state, steps.setting
    id_ = f"original/{key_of(state.type or state.name)}"
    setting.unknown.setdefault(id_, state)
    slots = {key_of(slot): value for slot, value in state.slots.items() if slot != "output"}
    read = {slot: name_of(str(value)) for slot, value in slots.items() if name_of(str(value)) in setting.produced}
    given = {slot: value for slot, value in slots.items() if slot not in read and value not in (None, "")}
    out = {"output": setting.variable(steps.slot("output"))} if steps.slot("output") else {}
    for name in read.values():
        setting.variable(name)
    steps.add("do", id_, with_=given, in_=read, out=out)
    steps.note("missing", f"{state.type or 'a state without type'} has no equal: write its class in nodes/original")
    return Made(steps.node(), {outcome: name_of(outcome) for outcome in state.outcomes})
