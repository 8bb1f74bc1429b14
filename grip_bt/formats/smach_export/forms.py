"""What each node of a task becomes in SMACH, as in the machine target; what has no equal is ticked by one state."""

from __future__ import annotations

from typing import Literal

from grip_bt.compilers.behaviour_state import Refined
from grip_bt.compilers.resolve import Part
from grip_bt.compilers.transitions import COUNT, counts, interrupts, table_of
from grip_bt.task import model

from .concurrence import outcome_map
from .keys import reads, shares, writes
from .legacy import is_next_item, legacy_state, names_inside

Form = Literal["state", "tree", "machine", "iterator", "items", "concurrence"]
"""A legacy state; a tree in a state; containers: StateMachine, Iterator over a variable, over literals, Concurrence."""

EXHAUSTED = "exhausted"


def form_of(part: Part, needed: Refined) -> Form:
    """Return what a node becomes.

    Args:
        part: the node.
        needed: (outcome, code) pairs for which its parent has an edge.
    """
    node = part.node
    if isinstance(node, model.Leaf):
        return "tree" if legacy_state(part) is None else "state"
    if isinstance(node, model.Foreign | model.Subtask | model.Cooldown):
        return "tree"
    if node.precondition or interrupts(part):
        return "tree"
    if isinstance(node, model.Parallel):
        ruled = bool(node.rules) and outcome_map(part) is None
        return "tree" if needed or ruled or _asks_for_codes(part) or shares(part) else "concurrence"
    if isinstance(node, model.ForEach):
        return "iterator" if _iterates(part, needed) else "tree"
    if counts(part) and needed:
        return "tree"
    return "items" if _hands_out_items(part) else "machine"


def _asks_for_codes(part: Part) -> bool:
    return any(code is not None for (_, _, code), _ in part.exits)


def _iterates(part: Part, needed: Refined) -> bool:
    """Tell whether an Iterator can hold the child: it passes its own userdata on, under no other names."""
    (child,) = part.children
    state = legacy_state(child)
    if state is not None and (state.remapping or state.outcomes):
        return False
    (row,) = table_of(part, needed).rows.values()
    leaving = {label: target for label, target in row.items() if target != COUNT}
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
