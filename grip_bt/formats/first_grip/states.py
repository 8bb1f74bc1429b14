"""States that came with the first GRIP: what each type does here, with its data in variables of the task."""

from __future__ import annotations

import re
from collections.abc import Callable

from .original import OriginalState
from .steps import PLAIN, STORES, Steps
from .words import is_hand, key_of, name_of


def moves_a_hand(state: OriginalState) -> bool:
    """Tell whether a state has a hand follow a trajectory, which no node does: hands go from posture to posture."""
    return state.type == "ExecuteTrajectory" and is_hand(str(state.slots.get("group_name") or ""))


def _compute_plan(steps: Steps) -> dict[str, str]:
    group, plan = steps.slot("group_name"), steps.slot("plan_name")
    given = {"goal": steps.value(steps.slot("target_name"), steps.slot("target_type"), "the target")}
    if start := steps.slot("starting_name"):
        if steps.slot("starting_type") == "pose":
            steps.note("missing", f"a plan that begins at a pose ({start!r}): it begins where the arm is; bind `start`")
        else:
            given["start"] = steps.value(start, steps.slot("starting_type"), "the start")
    variable = steps.setting.variable(plan or f"last_plan_{group or 'arm'}", "Plan")
    steps.add("plan", "arm/plan", with_=steps.setting.arm(group), in_=given, out={"plan": variable})
    return PLAIN


def _move(steps: Steps) -> dict[str, str]:
    group, plan = steps.slot("group_name"), steps.slot("plan_name")
    if not plan:
        steps.note("changed", "the plan that the commander kept to itself is a variable")
    known = not plan or name_of(plan) in steps.setting.produced
    name = plan or f"last_plan_{group or 'arm'}"
    variable = steps.setting.variable(name, "Plan") if known else steps.value(plan, "plan", "the plan")
    steps.add("move", "arm/execute", with_=steps.setting.arm(group), in_={"plan": variable})
    steps.note("changed", "ends with failure when the motion fails, which was ignored")
    return PLAIN


def _execute_trajectory(steps: Steps) -> dict[str, str]:
    group, name = steps.slot("group_name"), steps.slot("trajectory_name")
    variable = steps.produced(name) or steps.value(name, "trajectory", "the trajectory")
    arm = steps.setting.arm(group)
    steps.add("follow", "arm/execute_trajectory", with_=arm, in_={"trajectory": variable})
    steps.note("changed", "goes to where the trajectory begins; is checked before, and fails when it can't be followed")
    return PLAIN


def _wait_for(steps: Steps) -> dict[str, str]:
    seconds = _seconds(steps, "timeout")
    if topic := steps.slot("topic_name"):
        # its type is that of the publisher, as it was
        steps.add("wait", "ros/wait_for_message", with_={"topic": "/" + topic.strip("/"), "timeout": seconds})
        return PLAIN
    if seconds is None:
        steps.note("missing", "it waits for no topic and no time: say for how long in `seconds`")
    steps.add("wait", "flow/wait", with_={"seconds": seconds or 0.0})
    return {"success": "success"}


def _select(steps: Steps) -> dict[str, str]:
    output = steps.slot("output")
    if not output:
        steps.note("changed", "without `output` the value was dropped; it is only looked up")
    store, type_name = STORES.get(steps.slot("input_type"), ("", "Any"))
    target = {"value": steps.setting.variable(output, type_name)} if output else {}
    name = steps.slot("input")
    if store:
        steps.add("get", "messages/get", with_={"store": store, "name": name}, out=target)
        return PLAIN
    source = steps.value(name, "", "the input")
    steps.add("set", "flow/compute", with_={"expression": "a"}, in_={"a": source}, out=target)
    return {"success": "success", **({} if len(steps.steps) == 1 else {"failure": "failure"})}


def _counter(steps: Steps) -> dict[str, str]:
    first, last = _number(steps, "initial_value", 0), _number(steps, "end_value", None)
    down = last is not None and first is not None and last < first
    output = name_of(steps.slot("output") or "counter")
    if down:
        steps.note("missing", "it counts down; `flow/count` ends at a limit from below: turn its numbers round")
    steps.setting.variables[output] = {"type": "int", "value": (first or 0) - 1}
    limit = {} if last is None else {"limit": last}
    steps.add("count", "flow/count", with_=limit, in_={"count": output}, out={"count": output})
    return {"success": "success", "finished": "reached"} if last is not None else {"success": "success"}


def _number(steps: Steps, slot: str, otherwise: int | None) -> int | None:
    text = steps.slot(slot)
    if text in ("", "None"):
        return otherwise
    if re.fullmatch(r"-?\d{1,9}", text):
        return int(text)
    steps.note("missing", f"`{slot}` is {text!r} and no number")
    return otherwise


def _seconds(steps: Steps, slot: str) -> float | None:
    text = steps.slot(slot)
    if text in ("", "None"):
        return None
    if re.fullmatch(r"\d{1,9}(\.\d{0,9})?|\.\d{1,9}", text):
        return float(text)
    steps.note("missing", f"`{slot}` is {text!r} and no number of seconds")
    return None


def _reinitialise(steps: Steps) -> dict[str, str]:
    steps.add("reinitialise", "messages/reinitialise")
    return PLAIN


def _allow(steps: Steps) -> dict[str, str]:
    arm = steps.setting.arm(steps.slot("group_name")).get("arm", "*")
    allowed = steps.slot("allow").lower() in ("true", "1", "")
    listed = steps.state.slots.get("objects") or []
    names = re.findall(r"[\w./-]+", listed) if isinstance(listed, str) else [str(each) for each in listed]
    others = [arm] if steps.slot("collision").startswith("self") else names or ["*"]
    for other in others:
        pair = {"one": arm, "other": other, **({} if allowed else {"allowed": False})}
        steps.add(f"allow_{key_of(other)}" if other != "*" else "allow", "scene/allow_collisions", with_=pair)
    steps.note("changed", "allows and forbids as it says; it never did")
    return PLAIN


STATES: dict[str, Callable[[Steps], dict[str, str]]] = {
    "ComputePlan": _compute_plan,
    "Move": _move,
    "ExecuteTrajectory": _execute_trajectory,
    "WaitFor": _wait_for,
    "Select": _select,
    "Counter": _counter,
    "ReinitialiseManagers": _reinitialise,
    "AllowCollisions": _allow,
}
"""Type -> what adds its steps and returns its ends: outcome of the state -> outcome of the node."""
