"""States of the first GRIP as nodes: what each type does here, step by step, with its data in variables of the task."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from grip_bt.formats.imported import Issues
from grip_bt.formats.names import key_of

from .project import MESSAGES, Configuration, outcome_count
from .tasks import GripState, is_hand, name_of

STORES = {
    "joint state": ("joint_states", "JointState"),
    "pose": ("poses", "Pose"),
    "trajectory": ("trajectories", "Trajectory"),
    "plan": ("plans", "Plan"),
    "grasp": ("grasps", "Grasp"),
}
_PARTS = {"pregrasp": "pre_grasp", "grasp": "pose", "postgrasp": "post_grasp"}
"""Kind of a goal -> the part of a grasp that it is."""
PLAIN = {"success": "success", "failure": "failure"}
"""Ends of most states."""


Converted = tuple[dict[str, Any], dict[str, str]]
"""A node's keys, and outcome of the state -> outcome of the node; those that can't happen are left out."""


@dataclass
class ImportContext:
    """What a task's states stand in: the robot's configuration, and what was collected on the way.

    `produced`: userdata that some state writes. `unknown`: states without an equal, by the name of their node.
    """

    found: Configuration
    unknown: dict[str, GripState]
    issues: Issues
    produced: set[str] = field(default_factory=set)
    variables: dict[str, object] = field(default_factory=dict)

    @property
    def hand(self) -> str:
        """What a state that names no group takes for the hand."""
        return next((key_of(group) for group in self.found.part("planners") if is_hand(group)), "hand")

    def variable(self, name: str, type_name: str = "") -> str:
        """Return the variable of a name; it holds anything where it is written as more than one type."""
        name = name_of(name)
        known = self.variables.get(name, type_name or "Any")
        self.variables[name] = known if type_name in ("", known) else "Any"
        return name


def _arm(group: str) -> dict[str, str]:
    """Return the parameter that names an arm; none where the project has one only."""
    return {"arm": key_of(group)} if group else {}


class _Steps:
    """What one state does, step by step."""

    def __init__(self, state: GripState, context: ImportContext, place: str):
        self.state, self.context, self.place = state, context, place
        self.steps: dict[str, dict[str, object]] = {}

    def slot(self, name: str) -> str:
        value = self.state.slots.get(name)
        return "" if value is None else str(value).strip().strip("\"'")

    def note(self, code: str, text: str) -> None:
        self.context.issues.add(code, self.place, text)

    def add(self, step: str, node: str, **keys: Mapping[str, object]) -> dict[str, str]:
        """Add a step, whose empty keys are left out; return the ends of most states."""
        name = name_of(step, self.steps)
        said = {{"in_": "in", "with_": "with"}.get(key, key): dict(value) for key, value in keys.items() if value}
        self.steps[name] = {"node": node, **said}
        return PLAIN

    def value(self, name: str, kind: str, what: str) -> str:
        """Return the variable of a value, which may have to be got from a store first."""
        store, type_name = _store(kind)
        if not name and store:
            variable = self.context.variable(f"{kind} of {self.state.name}".replace(" ", "_"), type_name)
            self.add("take", "messages/take", with_={"store": store}, out={"value": variable})
            return variable
        if not store and name_of(name) not in self.context.produced:
            found = [(s, t) for s, t in STORES.values() if name in self.context.found.part(s)]
            store, type_name = found[0] if found else ("", "Any")
            if not found:
                text = f"{what} {name!r} is neither written by a state nor a stored message; give it a value"
                self.note("incomplete", text)
        if not store:
            return self.context.variable(name)
        known = self.context.found.part(store)
        if self.context.found.parts and store in MESSAGES and name not in known:
            self.note("incomplete", f"there is no {kind or 'message'} {name!r} in messages/{store}.yaml")
        variable = self.context.variable(f"{name} {type_name}".replace(" ", "_"), type_name)
        self.add(f"get_{key_of(name)}", "messages/get", with_={"store": store, "name": name}, out={"value": variable})
        return variable

    def node(self) -> dict[str, Any]:
        if len(self.steps) == 1:
            return next(iter(self.steps.values()))
        return {"kind": "sequence", "children": self.steps}


def _store(kind: str) -> tuple[str, str]:
    """Return the store of what a state names, and its type; empty and `Any` where it names the userdata."""
    return STORES.get("grasp" if kind in _PARTS else kind.replace("_", " "), ("", "Any"))


def _goal(steps: _Steps, which: str, what: str) -> str:
    """Return the variable of a joint state or pose, which may have to be taken out of a grasp."""
    kind = steps.slot(f"{which}_type")
    variable = steps.value(steps.slot(f"{which}_name"), kind, what)
    part = _PARTS.get(steps.slot(f"{which}_part") or kind)
    if not part:
        return variable
    pose = steps.context.variable(f"{what.removeprefix('the ')}_of_{steps.state.name}", "Pose")
    steps.add(
        f"{which}_pose", "flow/compute", with_={"expression": f"a.{part}"}, in_={"a": variable}, out={"value": pose}
    )
    return pose


def _compute_plan(steps: _Steps) -> dict[str, str]:
    group, plan = steps.slot("group_name"), steps.slot("plan_name")
    given = {"goal": _goal(steps, "target", "the target")}
    if steps.slot("starting_name") or steps.slot("starting_type"):
        given["start"] = _goal(steps, "starting", "the start")
    variable = steps.context.variable(plan or f"last_plan_{group or 'arm'}", "Plan")
    return steps.add("plan", "arm/plan", with_=_arm(group), in_=given, out={"plan": variable})


def _move(steps: _Steps) -> dict[str, str]:
    group, plan = steps.slot("group_name"), steps.slot("plan_name")
    if not plan:
        steps.note("changed", "the plan that the commander kept to itself is a variable")
    known = not plan or name_of(plan) in steps.context.produced
    name = plan or f"last_plan_{group or 'arm'}"
    variable = steps.context.variable(name, "Plan") if known else steps.value(plan, "plan", "the plan")
    steps.note("changed", "fails when the motion fails; the first GRIP ignored that")
    return steps.add("move", "arm/execute", with_=_arm(group), in_={"plan": variable})


def _execute_trajectory(steps: _Steps) -> dict[str, str]:
    name, arm = steps.slot("trajectory_name"), _arm(steps.slot("group_name"))
    produced = name_of(name) in steps.context.produced
    variable = steps.context.variable(name) if produced else steps.value(name, "trajectory", "the trajectory")
    steps.note("changed", "goes to where the trajectory begins; is checked before, and fails when it can't be followed")
    return steps.add("follow", "arm/execute_trajectory", with_=arm, in_={"trajectory": variable})


def _wait_for(steps: _Steps) -> dict[str, str]:
    seconds = _number(steps, "timeout", r"\d{1,9}(\.\d{0,9})?|\.\d{1,9}", " of seconds")
    if topic := steps.slot("topic_name"):
        # its type is that of the publisher, as it was
        return steps.add("wait", "ros/wait_for_message", with_={"topic": "/" + topic.strip("/"), "timeout": seconds})
    if seconds is None:
        steps.note("incomplete", "it waits for no topic and no time: say for how long in `seconds`")
    steps.add("wait", "flow/wait", with_={"seconds": seconds or 0.0})
    return {"success": "success"}


def _wait_for_signal(steps: _Steps) -> dict[str, str]:
    ends = _wait_for(steps)
    if ends is PLAIN:
        signal = steps.context.variable(f"signal_of_{steps.state.name}", "bool")
        wait: dict[str, Any] = steps.steps["wait"]
        wait["with"] |= {"type": "std_msgs/msg/Bool", "value": "bool"}
        wait["out"] = {"message": signal}
        steps.add("is_true", "flow/wait_until", with_={"expression": "a", "timeout": 0.0}, in_={"a": signal})
    return ends


def _select(steps: _Steps) -> dict[str, str]:
    output, kind, names = steps.slot("output"), steps.slot("input_type"), steps.state.slots.get("names")
    if not output:
        steps.note("changed", "without `output` the value was dropped; it is only looked up")
    store, type_name = _store(kind)
    target = {"value": steps.context.variable(output, type_name)} if output else {}
    name = steps.slot("input")
    if store and isinstance(names, list):
        return _select_in_turn(steps, store, [str(each) for each in names], target)
    if store:
        what = {"store": store, **({"name": name} if name else {})}
        return steps.add("get", "messages/get" if name else "messages/take", with_=what, out=target)
    source = steps.value(name, "", "the input")
    steps.add("set", "flow/compute", with_={"expression": "a"}, in_={"a": source}, out=target)
    return {"success": "success", **({} if len(steps.steps) == 1 else {"failure": "failure"})}


def _select_in_turn(steps: _Steps, store: str, names: list[str], target: dict[str, str]) -> dict[str, str]:
    """Get one message after the other, one each time that the state is entered, and fail when all have been got."""
    data, state = steps.context.variables, steps.state.name
    count, every, name = (name_of(f"{what}_of_{state}") for what in ("turns", "names", "name"))
    data[count], data[every], data[name] = {"type": "int", "value": -1}, {"type": "list[str]", "value": names}, "str"
    steps.add("turn", "flow/count", in_={"count": count}, out={"count": count})
    steps.add("choose", "flow/select", in_={"items": every, "index": count}, out={"item": name})
    return steps.add("get", "messages/select", with_={"store": store}, in_={"name": name}, out=target)


def _grasp(steps: _Steps) -> dict[str, str]:
    name = steps.slot("grasp_name")
    produced = "selected_grasp" in steps.state.reads
    variable = steps.value("selected_grasp", "", "the grasp") if produced else steps.value(name, "grasp", "the grasp")
    if steps.slot("grasp_type") == "postgrasp":
        steps.note("changed", "a grasp has no fingers of its own after the grasp: they go on closing")
    node = "hand/open" if steps.slot("grasp_type") == "pregrasp" else "hand/close"
    return steps.add("move_fingers", node, in_={"grasp": variable})


def _counter(steps: _Steps) -> dict[str, str]:
    first, last = (_number(steps, slot, r"-?\d{1,9}") for slot in ("initial_value", "end_value"))
    output = name_of(steps.slot("output") or "counter")
    if last is not None and last < (first or 0):
        steps.note("incomplete", "it counts down; `flow/count` ends at a limit from below: turn its numbers round")
    steps.context.variables[output] = {"type": "int", "value": int(first or 0) - 1}
    limit = {} if last is None else {"limit": int(last)}
    steps.add("count", "flow/count", with_=limit, in_={"count": output}, out={"count": output})
    return {"success": "success", "finished": "reached"} if last is not None else {"success": "success"}


def _number(steps: _Steps, slot: str, pattern: str, unit: str = "") -> float | None:
    text = steps.slot(slot)
    if text in ("", "None"):
        return None
    if re.fullmatch(pattern, text):
        return float(text)
    steps.note("incomplete", f"`{slot}` is {text!r} and not a number{unit}")
    return None


def _allow(steps: _Steps) -> dict[str, str]:
    arm = _arm(steps.slot("group_name")).get("arm", steps.context.hand)
    allowed = steps.slot("allow").lower() in ("true", "1", "")
    listed = steps.state.slots.get("objects") or []
    names = re.findall(r"[\w./-]+", listed) if isinstance(listed, str) else [str(each) for each in listed]
    others = [arm] if steps.slot("collision").startswith("self") else names or ["*"]
    for other in others:
        pair = {"one": arm, "other": other, **({} if allowed else {"allowed": False})}
        steps.add(f"allow_{key_of(other)}" if other != "*" else "allow", "scene/allow_collisions", with_=pair)
    steps.note("changed", "now allows or forbids collisions as configured; the first GRIP ignored the setting")
    return PLAIN


STATES: dict[str, Callable[[_Steps], dict[str, str]]] = {
    "ComputePlan": _compute_plan,
    "Move": _move,
    "ExecuteTrajectory": _execute_trajectory,
    "WaitFor": _wait_for,
    "Select": _select,
    "Counter": _counter,
    "ReinitialiseManagers": lambda steps: steps.add("reinitialise", "messages/reinitialise"),
    "AllowCollisions": _allow,
    "Grasp": _grasp,
    "WaitForSignal": _wait_for_signal,
}
"""Type -> what adds its steps and returns its ends: outcome of the state -> outcome of the node."""


def node_of(state: GripState, context: ImportContext, place: str) -> Converted:
    """Return a state as a node."""
    steps = _Steps(state, context, place)
    # no node has a hand follow a trajectory: hands go from posture to posture
    moves_a_hand = state.type == "ExecuteTrajectory" and is_hand(str(state.slots.get("group_name") or ""))
    if state.type in STATES and not moves_a_hand:
        ends = STATES[state.type](steps)
        return steps.node(), _by_place(ends, state.outcomes)
    if state.type in context.found.part("components"):
        return _component(steps)
    if state.type in context.found.part("sensors"):
        key, alias = key_of(state.type), key_of(steps.slot("sensor_topic") or "data")
        out = {alias: context.variable(steps.slot("output"))} if steps.slot("output") else {}
        steps.add("look", f"sensor/{key}", out=out)
        return steps.node(), PLAIN
    return _unknown(steps)


def _by_place(ends: dict[str, str], outcomes: list[str]) -> dict[str, str]:
    """Return the ends by a state's own names: its first outcome is its success, its last the failure."""
    own = {end: outcomes[place] for end, place in (("success", 0), ("failure", -1)) if end not in outcomes}
    return {own.get(outcome, outcome): end for outcome, end in ends.items()}


def _component(steps: _Steps) -> Converted:
    key, count = key_of(steps.state.type), outcome_count(steps.context.found.part("components")[steps.state.type])
    given = {"input": _input(steps)} if steps.slot("input") else {}
    output, store = steps.slot("output"), STORES.get(steps.slot("output_type"), ("", ""))[0]
    returned = steps.context.variable(output) if output else ""
    out = {"returned_object": returned} if returned else {}
    steps.add("call", f"component/{key}", in_=given, out=out)
    if store:
        steps.note("incomplete", f"its result went to the {store} as {output!r}; add `messages/put` after it")
    ends = {str(number): f"outcome_{number}" for number in range(count)} | {"state_failure": "failure"}
    if len(steps.steps) == 1:
        return steps.node(), ends
    exits = {f"call.outcome_{number}": f"outcome_{number}" for number in range(count)}
    outcomes = dict.fromkeys(exits.values(), "success")
    return {**steps.node(), "outcomes": outcomes, "exits": exits}, ends


def _input(steps: _Steps) -> str:
    """Return the variable of what a component is given: text in quotes and what isn't text are literals."""
    value = steps.state.slots["input"]
    if isinstance(value, str) and not re.fullmatch(r"\"[^\"]*\"", value.strip()):
        return steps.value(steps.slot("input"), steps.slot("input_type"), "the input")
    literal = value.strip()[1:-1] if isinstance(value, str) else value
    variable = steps.context.variable(f"input_of_{steps.state.name}")
    steps.add("set_input", "flow/set", with_={"value": literal}, out={"value": variable})
    return variable


def _unknown(steps: _Steps) -> Converted:
    """Return a node of the project's own whose class has to be filled in; all states of a type share it."""
    state, context = steps.state, steps.context
    id_ = f"original/{key_of(state.type or state.name)}"
    shared = context.unknown.setdefault(id_, GripState(state.name, state.type))
    shared.slots |= state.slots
    for of_all, own in ((shared.outcomes, state.outcomes), (shared.writes, state.writes)):
        of_all += [name for name in own if name not in of_all]
    slots = {key_of(slot): value for slot, value in state.slots.items() if slot != "output"}
    read = {slot: name_of(str(value)) for slot, value in slots.items() if name_of(str(value)) in context.produced}
    given = {slot: value for slot, value in slots.items() if slot not in read and value not in (None, "")}
    read |= {key_of(key): name_of(key) for key in state.reads if name_of(key) in context.produced}
    shared.reads += [key for key in state.reads if key_of(key) in read and key not in shared.reads]
    out = {"output": context.variable(steps.slot("output"))} if steps.slot("output") else {}
    out |= {key_of(key): context.variable(key) for key in state.writes}
    for name in read.values():
        context.variable(name)
    steps.add("do", id_, with_=given, in_=read, out=out)
    what = state.type or "a state without type"
    steps.note("incomplete", f"{what} has no equivalent; write its class: nodes/original")
    return steps.node(), {outcome: name_of(outcome) for outcome in state.outcomes}
