"""How each container is written: its states first, then its object, then what adds these to it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from grip_bt.compilers.behaviour_state import Refined, labels
from grip_bt.compilers.machine_table import AGAIN, chooses, counts, state_labels, table_of
from grip_bt.compilers.resolve import Part
from grip_bt.formats.python_source import Bracketed, Raw, call
from grip_bt.formats.smach_export.forms import (
    is_next_item,
    is_obeyed,
    legacy_state,
    names_inside,
    reads,
    writes,
)
from grip_bt.task import model

from .forms import outcome_map, smach_form
from .states import SourceBuilder, keys_of, legacy, tree

Made = Bracketed | Raw


def state(builder: SourceBuilder, part: Part, needed: Refined) -> Made:
    """Return the expression of a node's state; containers are written before it."""
    form = smach_form(part, needed)
    if form == "state":
        return legacy(builder, part)
    if form == "tree":
        return tree(builder, part, needed)
    return Raw(_CONTAINERS[form](builder, part, needed))


def machine(
    builder: SourceBuilder,
    part: Part,
    needed: Refined,
    name: str = "",
    ends: Mapping[str, str] | None = None,
    outcomes: list[str] | None = None,
    then: Callable[[], None] | None = None,
) -> str:
    """Write a StateMachine of children that run one after the other, and return its name.

    `ends` and `outcomes` are what its outcomes are called, `then` writes what comes between its object and its states.
    """
    table, names, ends = table_of(part, needed), state_labels(part), ends or {}
    states = {child.name: state(builder, child, table.refined[child.name]) for child in part.children}
    name = name or builder.take(part)
    keys = {} if outcomes else keys_of(part)
    builder.begin(name, call("smach.StateMachine", outcomes=outcomes or labels(part.meaning, needed), **keys), part)
    if then is not None:
        then()
    ask, leads = "", dict[str, str]()
    if counts(part):
        assert isinstance(part.node, model.Retry | model.Repeat), "only these count"
        builder.parts.add("count")
        ask = builder.identifiers.take(f"attempts_of_{name}")
        builder.write(call("Count", part.node.times), ask)
        end = "failure" if isinstance(part.node, model.Retry) else "success"
        leads = {"again": names[part.children[0].name], "enough": ends.get(end, end)}
    elif chooses(part):
        ask = _choice(builder, part, needed, name)
        leads = {f"do {child.name}": names[child.name] for child in part.children}
        leads |= {end: ends.get(end, end) for end in labels(("success", "failure"), _failures(needed))}
    if ask:
        builder.write(call(f"{name}.register_start_cb", Raw(f"{ask}.begin")))
    builder.body.append(f"    with {name}:")
    for child in part.children:
        ways = {label: ends.get(to, to) for label, to in table.rows[names[child.name]].items()}
        add(builder, names[child.name], states[child.name], child, table.refined[child.name], ways)
    if ask:
        builder.write(call("smach.StateMachine.add", AGAIN, Raw(ask), transitions=leads), "", 8)
    if table.initial != names[part.children[0].name]:
        builder.write(call(f"{name}.set_initial_state", [table.initial]), "", 4)
    return name


_OUTSIDE = {"on", "x", "doc", "data", "exits", "child", "children"}
"""What of a switch or a loop isn't asked of its kind."""


def _choice(builder: SourceBuilder, part: Part, needed: Refined, name: str) -> str:
    builder.parts.add("Choose")
    more: dict[str, object] = {"place": part.path}
    if failures := _failures(needed):
        more["codes"] = [f"{outcome}.{code}" for outcome, code in sorted(failures)]
    node = part.node.model_dump(by_alias=True, exclude_unset=True, mode="json", exclude=_OUTSIDE)
    made = call("Choose", Raw("run"), node, [child.name for child in part.children], **more)
    choice = builder.identifiers.take(f"choice_of_{name}")
    builder.write(made, choice)
    return choice


def _failures(needed: Refined) -> set[tuple[str, str]]:
    return {(outcome, code) for outcome, code in needed if outcome == "failure"}


def add(
    builder: SourceBuilder,
    label: str,
    made: Made,
    part: Part,
    refined: Refined,
    leads: Mapping[str, str] | None,
) -> None:
    """Write what adds a state to a StateMachine, or without transitions to a Concurrence."""
    given: dict[str, object] = {}
    known = legacy_state(part) if smach_form(part, refined) == "state" else None
    if leads is not None:
        if known is not None:  # legacy states give no failure codes, and may call their outcomes otherwise
            leads = {known.outcomes.get(o, o): to for o, to in leads.items() if "." not in o}
        given["transitions"] = dict(leads)
    if known is not None and known.remapping:
        given["remapping"] = known.remapping
    if smach_form(part, refined) == "items":
        if renamed := {key: variable for variable, key in _names(part).items() if key != variable}:
            given["remapping"] = renamed
    builder.write(call(f"smach.{'Concurrence' if leads is None else 'StateMachine'}.add", label, made, **given), "", 8)


def _items(builder: SourceBuilder, part: Part, needed: Refined) -> str:
    """Write what an import had made of an Iterator as one."""
    assert isinstance(part.node, model.StateMachine), "it is a machine of these"
    first = next(child for child in part.children if child.name == part.node.initial)
    other = next(child for child in part.children if not is_next_item(child))
    table = table_of(part, needed)
    made = state(builder, other, table.refined[other.name])
    assert isinstance(first.node, model.Leaf), "it hands out items"
    names = _names(part)
    given = {
        "input_keys": list(names.values()),
        "output_keys": list(names.values()),
        "it": first.node.with_["items"],
        "it_label": names[first.node.out["item"]],
        "exhausted_outcome": first.node.on["exhausted"],
    }
    name = builder.take(part)
    builder.body.append("")
    builder.write(call("smach.Iterator", outcomes=labels(part.meaning, needed), **given), name)
    again = {child.name for child in part.children if is_next_item(child)}
    mapped: dict[str, str] = {}
    for step in part.children:
        node = step.node
        if is_next_item(step) and isinstance(node, model.Leaf) and not node.with_.get("leaves_by"):
            into = [label for label, to in table.rows[other.name].items() if to == step.name]
            mapped |= {label: node.on.get("preempted", label) for label in into}
    _contained(builder, name, other, made, table.rows[other.name], again, mapped)
    return name


def _names(part: Part) -> dict[str, str]:
    """Return variable -> key of what was an Iterator."""
    other = next(child for child in part.children if not is_next_item(child))
    return names_inside(legacy_state(other), {**reads(part), **writes(part)}) or {}


def _contained(
    builder: SourceBuilder,
    name: str,
    child: Part,
    made: Made,
    row: Mapping[str, str],
    again: set[str],
    loops_to: Mapping[str, str],
) -> None:
    """Write the state of an Iterator; `loops_to`: what it ends with when it is preempted after these outcomes."""
    row = {label: to for label, to in row.items() if legacy_state(child) is None or "." not in label}
    leaving = {label: to for label, to in row.items() if to not in again}
    loops = [label for label in row if label not in leaving]
    given: dict[str, object] = {"loop_outcomes": loops, "break_outcomes": list(leaving)}
    ways = {**leaving, **{label: to for label, to in loops_to.items() if label in loops}}
    if mapped := {label: to for label, to in ways.items() if label != to}:
        given["final_outcome_map"] = mapped
    builder.body.append(f"    with {name}:")
    builder.write(call("smach.Iterator.set_contained_state", child.name, made, **given), "", 8)


def _concurrence(builder: SourceBuilder, part: Part, needed: Refined) -> str:
    names = state_labels(part)
    children = [child for child in part.children if not is_obeyed(child)]
    states = {child.name: state(builder, child, ()) for child in children}
    name, said = builder.take(part), outcome_map(part)
    assert said is not None, "this form is for those"
    mapped = {o: {names[c]: end for c, end in ends.items()} for o, ends in said[0].items()}
    outcomes, more = labels(part.meaning, needed), {"outcome_map": mapped}
    made = call("smach.Concurrence", outcomes=outcomes, default_outcome=said[1], **keys_of(part), **more)
    builder.begin(name, made, part)
    builder.body.append(f"    with {name}:")
    for child in children:
        add(builder, names[child.name], states[child.name], child, (), None)
    return name


_CONTAINERS: dict[str, Callable[[SourceBuilder, Part, Refined], str]] = {
    "machine": machine,
    "items": _items,
    "concurrence": _concurrence,
}
