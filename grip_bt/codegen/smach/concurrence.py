"""How a Concurrence comes to the outcome of a parallel that joins: by an outcome map if one says it, or a function."""

from __future__ import annotations

from grip_bt.compilers.resolve import Part
from grip_bt.graph import model

from ..quoting import py


def outcome_map(part: Part) -> tuple[dict[str, dict[str, str]], str] | None:
    """Return outcome -> {child: its outcome}, and the default outcome; None where no map says what the parallel does.

    SMACH takes the entry with the most conditions that hold, the first of equals; a parallel looks at its exits first,
    in its children's order.
    """
    node = part.node
    assert isinstance(node, model.Parallel), "only these join"
    if node.policy != "all":
        return None
    order = {child.name: number for number, child in enumerate(part.children)}
    exits = sorted(part.exits, key=lambda exit: order[exit[0][0]])
    mapped: dict[str, dict[str, str]] = {}
    for (child, outcome, _), target in exits:
        if target in mapped or target in ("success", "failure"):
            return None
        mapped[target] = {child: outcome}
    wanted = {}
    for child in part.children:
        good = [outcome for outcome, meaning in child.meaning.items() if meaning == "success"]
        if len(good) == len(child.meaning):
            continue
        if len(good) != 1 or {child.name: good[0]} in mapped.values():
            return None
        wanted[child.name] = good[0]
    return ({**mapped, "success": wanted}, "failure") if wanted else (mapped, "success")


def outcome_function(part: Part, name: str, labels: dict[str, str]) -> str:
    """Return a function that says the outcome from those of the children."""
    node = part.node
    assert isinstance(node, model.Parallel), "only these join"
    lines = [f"def {name}(ends):", f'    """Return the outcome of {part.name} from those of its children."""']
    order = {child.name: number for number, child in enumerate(part.children)}
    for (child, outcome, _), target in sorted(part.exits, key=lambda exit: order[exit[0][0]]):
        lines += [f"    if ends[{py(labels[child])}] == {py(outcome)}:", f"        return {py(target)}"]
    lines.append("    good = [")
    for child in part.children:
        ends = [outcome for outcome, meaning in child.meaning.items() if meaning == "success"]
        lines.append(f"        ends[{py(labels[child.name])}] in {py(ends)},")
    lines += ["    ]", f'    return "success" if {node.policy}(good) else "failure"']
    return "\n".join(lines)
