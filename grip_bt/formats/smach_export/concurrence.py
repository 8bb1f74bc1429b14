"""How a Concurrence comes to the outcome of a parallel that joins: by an outcome map if one says it, or a function."""

from __future__ import annotations

from grip_bt.base.python_literals import py
from grip_bt.compilers.resolve import Part
from grip_bt.task import model

from .legacy import is_obeyed


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
