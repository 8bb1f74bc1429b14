"""A task of the first GRIP -> a task: containers, edges, and a node for each state."""

from __future__ import annotations

from typing import Any

from pydantic import ValidationError

from grip_bt.base.errors import GripError
from grip_bt.task import Task

from .nodes import node_of
from .original import Note, OriginalContainer, OriginalState
from .steps import Setting
from .words import meanings, name_of


def task_of(root: OriginalContainer, setting: Setting) -> Task:
    """Return the task; what isn't as it was is added to the setting's notes.

    Raises:
        GripError: it can't be written as a task.
    """
    for state in root.states():
        output, stored = state.slots.get("output"), state.slots.get("output_type")
        if output and not stored:
            setting.produced.add(name_of(str(output)))
        if state.type == "ComputePlan" and state.slots.get("plan_name"):
            setting.produced.add(name_of(str(state.slots["plan_name"])))
    node = _container(root, setting, root.name)
    outcomes = {name_of(outcome): meaning for outcome, meaning in meanings(root.outcomes).items()}
    document = {
        "grip": 1,
        "name": name_of(root.name),
        "doc": "Imported from a task of the first GRIP.",
        "outcomes": outcomes,
        "data": setting.variables,
        "root": node,
    }
    try:
        return Task.model_validate(document)
    except ValidationError as error:
        first = error.errors()[0]
        raise GripError(f"{root.name}: {'/'.join(map(str, first['loc']))}: {first['msg']}") from None


def _container(found: OriginalContainer, setting: Setting, place: str) -> dict[str, Any]:
    names: dict[str, str] = {}
    taken = {name_of(outcome) for outcome in found.outcomes}
    for label in found.children:
        names[label] = name_of(label, taken)
        taken.add(names[label])
        if names[label] != label:
            setting.notes.append(Note("changed", place, f"the state {label!r} is called {names[label]!r}"))
    if found.concurrent:
        return _parallel(found, names, setting, place)
    children = {}
    for label, child in found.children.items():
        node, ends = _child(child, setting, f"{place}/{label}")
        on = {end: _target(found, child, outcome, names, setting, place) for outcome, end in ends.items()}
        children[names[label]] = {**node, "on": on}
    if found.initial not in names:
        raise GripError(f"{place}: it begins with {found.initial!r}, which isn't there")
    outcomes = {name_of(outcome): meaning for outcome, meaning in meanings(found.outcomes).items()}
    return {"kind": "state_machine", "initial": names[found.initial], "outcomes": outcomes, "children": children}


def _parallel(found: OriginalContainer, names: dict[str, str], setting: Setting, place: str) -> dict[str, Any]:
    """Return a parallel that waits for all and goes by rules; SMACH takes the rule with the most conditions."""
    children, ends = {}, {}
    for label, child in found.children.items():
        children[names[label]], ends[label] = _child(child, setting, f"{place}/{label}")
    rules = []
    for outcome, when in sorted(found.rules.items(), key=lambda rule: -len(rule[1])):
        if unknown := [label for label in when if label not in names]:
            setting.notes.append(Note("missing", place, f"a rule for {outcome!r} names {unknown}, which aren't there"))
            continue
        said = {names[label]: [ends[label].get(o, name_of(o)) for o in wanted] for label, wanted in when.items()}
        rules.append({"when": said, "then": name_of(outcome)})
        for label, wanted in when.items():
            if len(wanted) > 1:
                text = f"{wanted} of {label!r} lead to {outcome!r}: any of them will do; only the last counted"
                setting.notes.append(Note("changed", place, text))
    rules.append({"then": name_of(found.default)})
    outcomes = {name_of(outcome): meaning for outcome, meaning in meanings(found.outcomes).items()}
    own = {outcome: meaning for outcome, meaning in outcomes.items() if outcome not in ("success", "failure")}
    return {"kind": "parallel", "cancel": "join", "rules": rules, "outcomes": own, "children": children}


def _child(child: OriginalState, setting: Setting, place: str) -> tuple[dict[str, Any], dict[str, str]]:
    if isinstance(child, OriginalContainer):
        node = _container(child, setting, place)
        ends = {outcome: name_of(outcome) for outcome in child.outcomes}
        if child.concurrent:  # a parallel may end with these too, as far as its document says
            ends |= {end: end for end in ("success", "failure") if end not in ends.values()}
        return node, ends
    made = node_of(child, setting, place)
    return made.node, made.ends


def _target(
    found: OriginalContainer, child: OriginalState, outcome: str, names: dict[str, str], setting: Setting, place: str
) -> str:
    target = child.leads.get(outcome)
    if target in names:
        return names[str(target)]
    if target in found.outcomes:
        return name_of(str(target))
    if outcome in child.outcomes:
        text = f"{outcome!r} of {child.name!r} led to {target or 'nothing'}; it leads to {found.outcomes[-1]!r}"
        setting.notes.append(Note("missing", place, text))
    return name_of(found.outcomes[-1])
