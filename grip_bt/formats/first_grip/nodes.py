"""States of the first GRIP as nodes: its own, those of components and sensors, and those that nobody knows."""

from __future__ import annotations

import re
from typing import Any

from grip_bt.formats.names import key_of

from .original import GripState
from .states import STATES, moves_a_hand
from .steps import PLAIN, STORES, ConvertedState, ImportContext, StepBuilder
from .words import name_of


def node_of(state: GripState, context: ImportContext, place: str) -> ConvertedState:
    """Return a state as a node."""
    steps = StepBuilder(state, context, place)
    if state.type in STATES and not moves_a_hand(state):
        ends = STATES[state.type](steps)
        return ConvertedState(steps.node(), ends)
    if state.type in context.components:
        return _component(steps)
    if state.type in context.sensors:
        return ConvertedState(_sensor(steps), PLAIN)
    return _unknown(steps)


def _component(steps: StepBuilder) -> ConvertedState:
    key, count = steps.context.components[steps.state.type]
    given = {"input": _input(steps)} if steps.slot("input") else {}
    output, store = steps.slot("output"), STORES.get(steps.slot("output_type"), ("", ""))[0]
    returned = steps.context.variable(output) if output else ""
    out = {"returned_object": returned} if returned else {}
    steps.add("call", f"component/{key}", in_=given, out=out)
    if store:
        steps.note("incomplete", f"its result went to the {store} as {output!r}; add `messages/put` after it")
    ends = {str(number): f"outcome_{number}" for number in range(count)} | {"state_failure": "failure"}
    if len(steps.steps) == 1:
        return ConvertedState(steps.node(), ends)
    exits = {f"call.outcome_{number}": f"outcome_{number}" for number in range(count)}
    outcomes = dict.fromkeys(exits.values(), "success")
    return ConvertedState({**steps.node(), "outcomes": outcomes, "exits": exits}, ends)


def _input(steps: StepBuilder) -> str:
    """Return the variable of what a component is given: text in quotes and what isn't text are literals."""
    value = steps.state.slots["input"]
    if isinstance(value, str) and not re.fullmatch(r"\"[^\"]*\"", value.strip()):
        return steps.value(steps.slot("input"), steps.slot("input_type"), "the input")
    literal = value.strip()[1:-1] if isinstance(value, str) else value
    variable = steps.context.variable(f"input_of_{steps.state.name}")
    steps.add("set_input", "flow/set", with_={"value": literal}, out={"value": variable})
    return variable


def _sensor(steps: StepBuilder) -> dict[str, Any]:
    key, alias = steps.context.sensors[steps.state.type], key_of(steps.slot("sensor_topic") or "data")
    out = {alias: steps.context.variable(steps.slot("output"))} if steps.slot("output") else {}
    steps.add("look", f"sensor/{key}", out=out)
    return steps.node()


def _unknown(steps: StepBuilder) -> ConvertedState:
    """Return a node of the project's own whose class has to be filled in."""
    state, context = steps.state, steps.context
    id_ = f"original/{key_of(state.type or state.name)}"
    context.unknown.setdefault(id_, state)
    slots = {key_of(slot): value for slot, value in state.slots.items() if slot != "output"}
    read = {slot: name_of(str(value)) for slot, value in slots.items() if name_of(str(value)) in context.produced}
    given = {slot: value for slot, value in slots.items() if slot not in read and value not in (None, "")}
    out = {"output": context.variable(steps.slot("output"))} if steps.slot("output") else {}
    for name in read.values():
        context.variable(name)
    steps.add("do", id_, with_=given, in_=read, out=out)
    steps.note("incomplete", f"{state.type or 'a state without type'} has no equal: write its class in nodes/original")
    return ConvertedState(steps.node(), {outcome: name_of(outcome) for outcome in state.outcomes})
