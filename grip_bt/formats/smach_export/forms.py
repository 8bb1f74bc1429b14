"""What a node becomes in SMACH: a container and how it comes to its outcome, a legacy state, or one that ticks it."""

from __future__ import annotations

from typing import Literal

from grip_bt.base.python_literals import py
from grip_bt.compilers.behaviour_state import Refined
from grip_bt.compilers.machine_table import AGAIN, chooses, counts, interrupts, table_of
from grip_bt.compilers.resolve import Part
from grip_bt.task import model

from .legacy import is_next_item, is_obeyed, legacy_state, names_inside, reads, shares, writes

SmachForm = Literal["state", "tree", "machine", "iterator", "items", "concurrence"]
"""A legacy state; a tree in a state; containers: StateMachine, Iterator over a variable, over literals, Concurrence."""
EXHAUSTED = "exhausted"


def outcome_map(part: Part) -> tuple[dict[str, dict[str, str]], str] | None:
    """Return outcome -> {child: its outcome}, and the default outcome; None where no map says what the parallel does.

    SMACH takes the entry with the most conditions that hold, the first of equals; a parallel looks at its exits first,
    in its children's order.
    """
    node = part.node
    assert isinstance(node, model.Parallel), "only these join"
    if node.rules:
        return _ruled(part, node)
    if node.policy != "all":
        return None
    order = {child.name: number for number, child in enumerate(part.children)}
    exits = sorted(part.exits, key=lambda exit: order[exit[0][0]])
    mapped: dict[str, dict[str, str]] = {}
    for (name, outcome, _), target in exits:
        if target in mapped or target in ("success", "failure"):
            return None
        mapped[target] = {name: outcome}
    wanted = {}
    for child in part.children:
        good = [outcome for outcome, meaning in child.meaning.items() if meaning == "success"]
        if len(good) == len(child.meaning):
            continue
        if len(good) != 1 or {child.name: good[0]} in mapped.values():
            return None
        wanted[child.name] = good[0]
    return ({**mapped, "success": wanted}, "failure") if wanted else (mapped, "success")


def _ruled(part: Part, node: model.Parallel) -> tuple[dict[str, dict[str, str]], str] | None:
    """Return rules as a map: each about one outcome of each child, the longer ones first, and one for the rest."""
    obeyed = {child.name for child in part.children if is_obeyed(child)}
    *rules, rest = [rule for rule in node.rules if not set(rule.when) & obeyed]
    mapped = {rule.then: {child: str(said) for child, said in rule.when.items()} for rule in rules}
    sizes = [len(rule.when) for rule in rules]
    plain = all(isinstance(said, str) for rule in rules for said in rule.when.values())
    counts = any(rule.at_least is not None for rule in node.rules)
    if part.exits or not plain or counts or rest.when or len(mapped) < len(rules) or 0 in sizes:
        return None
    return (mapped, rest.then) if sizes == sorted(sizes, reverse=True) else None


def outcome_function(part: Part, name: str, labels: dict[str, str]) -> str:
    """Return a function that says the outcome from those of the children."""
    node = part.node
    assert isinstance(node, model.Parallel), "only these join"
    lines = [f"def {name}(ends):", f'    """Return the outcome of {part.name} from those of its children."""']
    order = {child.name: number for number, child in enumerate(part.children)}
    for (joined, outcome, _), target in sorted(part.exits, key=lambda exit: order[exit[0][0]]):
        lines += [f"    if ends[{py(labels[joined])}] == {py(outcome)}:", f"        return {py(target)}"]
    lines.append("    good = [")
    for child in part.children:
        ends = [outcome for outcome, meaning in child.meaning.items() if meaning == "success"]
        lines.append(f"        ends[{py(labels[child.name])}] in {py(ends)},")
    lines += ["    ]", f'    return "success" if {node.policy}(good) else "failure"']
    return "\n".join(lines)


def smach_form(part: Part, needed: Refined) -> SmachForm:
    """Return what a node becomes; `needed`: (outcome, code) pairs for which its parent has an edge."""
    node = part.node
    if isinstance(node, model.Leaf):
        return "tree" if legacy_state(part) is None else "state"
    if isinstance(node, model.Foreign | model.Subtask) or node.precondition or interrupts(part):
        return "tree"
    if chooses(part) and not isinstance(node, model.Switch | model.Loop | model.ForEach):
        return "tree"
    if isinstance(node, model.Parallel):
        ruled = bool(node.rules) and outcome_map(part) is None
        by_code = any(code is not None for (_, _, code), _ in part.exits)
        return "tree" if needed or ruled or by_code or shares(part) else "concurrence"
    if isinstance(node, model.ForEach):
        return "iterator" if _iterates(part, needed) else "tree"
    if counts(part) and needed:
        return "tree"
    return "items" if _hands_out_items(part) else "machine"


def _iterates(part: Part, needed: Refined) -> bool:
    """Tell whether an Iterator can hold the child: it passes its own userdata on, under no other names."""
    (child,) = part.children
    state = legacy_state(child)
    if state is not None and (state.remapping or state.outcomes):
        return False
    (row,) = table_of(part, needed).rows.values()
    leaving = {label: target for label, target in row.items() if target != AGAIN}
    return EXHAUSTED not in leaving and leaving.get("success", "success") == "success"


def _hands_out_items(part: Part) -> bool:
    """Tell whether a machine is what an import makes of an Iterator."""
    if not isinstance(part.node, model.StateMachine):
        return False
    steps = {child.name: child.node.on for child in part.children if is_next_item(child)}
    others = [child for child in part.children if not is_next_item(child)]
    if len(others) != 1 or part.node.initial not in steps:
        return False
    (other,) = others
    state = legacy_state(other)
    named = names_inside(state, {**reads(part), **writes(part)}) is not None
    plain = named and (state is None or not state.outcomes)
    ended = steps[part.node.initial].get("exhausted", "")
    alike = all(on.get("item") == other.name and on.get("exhausted") == ended for on in steps.values())
    rest = {label: target for label, target in other.node.on.items() if target not in steps}
    return plain and alike and rest.get(ended, ended) == ended
