"""What a drawing says about a task, before any geometry: words for nodes, and the links between children."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from grip_bt.task import (
    AnyNode,
    Container,
    Cooldown,
    Fallback,
    Force,
    ForEach,
    Foreign,
    Guard,
    Leaf,
    Loop,
    Parallel,
    ParallelRule,
    Repeat,
    Retry,
    Sequence,
    StateMachine,
    Subtask,
    Switch,
    Timeout,
    children_of,
    outcomes_of,
)

View = Literal["tree", "flow"]
GLYPHS = {
    "leaf": "",
    "sequence": "→",
    "fallback": "?",
    "parallel": "⇉",
    "state_machine": "◎",
    "retry": "↻",
    "repeat": "↻",
    "timeout": "◔",
    "guard": "⊨",
    "switch": "⑂",
    "for_each": "∀",
    "loop": "↻",
    "cooldown": "◔",
    "foreign": "⇲",
    "subtask": "▣",
    "invert": "!",
    "force": "=",
}
"""A sign per kind, for text; pictures draw theirs."""


@dataclass(frozen=True)
class Link:
    """A connection between two children, or from a child to an outcome of their container.

    Attributes:
        source: a child's name; empty for the start of a state machine or a switch.
        target: a child's name, or an outcome's.
        label: the ends that take it; empty where order alone decides.
        to_outcome: whether `target` is an outcome.
    """

    source: str
    target: str
    label: str
    to_outcome: bool = False


def kind_of(node: AnyNode) -> str:
    """Return `leaf` or the container's kind."""
    return "leaf" if isinstance(node, Leaf) else node.kind


def describe(node: AnyNode) -> str:
    """Return what a node is, in a few words."""
    match node:
        case Leaf():
            return node.node
        case Sequence() | Fallback():
            return node.kind if node.memory else f"reactive {node.kind}"
        case Parallel():
            return f"parallel, {_parallel(node)}"
        case Foreign():
            return node.behaviour
        case Subtask():
            return f"subtask {node.task}"
        case StateMachine():
            return "state machine"
        case Retry():
            return f"retry, at most {node.times} times"
        case Repeat():
            return "repeat for ever" if node.times is None else f"repeat {node.times} times"
        case Timeout():
            return f"timeout {node.seconds:g} s"
        case Guard():
            return f"guard: {node.if_}"
        case Force():
            return f"force {node.as_}"
        case _:
            return _chooser(node)


def _chooser(node: Container) -> str:
    match node:
        case Switch():
            return f"switch on {node.on_value}"
        case ForEach():
            return f"for each {node.item} in {node.items}"
        case Loop():
            limit = "" if node.times is None else f", at most {node.times} times"
            return (f"loop while {node.while_}" if node.while_ else "loop") + limit
        case Cooldown():
            return f"cooldown {node.seconds:g} s"
        case _:
            return node.kind


def details(node: AnyNode) -> list[str]:
    """Return further lines about a node: literals, and where its ends lead."""
    lines = [f"only if {node.precondition}"] if node.precondition else []
    if isinstance(node, Leaf | Subtask) and node.with_:
        lines.append(", ".join(f"{name}={value}" for name, value in node.with_.items()))
    if isinstance(node, Foreign) and node.args:
        lines.append(", ".join(f"{name}={value}" for name, value in node.args.items()))
    lines.extend(f"{label} → {target}" for label, target in node.on.items())
    if isinstance(node, Parallel):
        lines.extend(f"{rule_text(rule)} ⇥ {rule.then}" for rule in node.rules)
    if not isinstance(node, Leaf | StateMachine):
        lines.extend(f"{end} ⇥ {target}" for end, target in node.exits.items())
    return lines


def _parallel(node: Parallel) -> str:
    """Return what decides a parallel, whom it waits for, and what becomes of the rest."""
    words = ["rules" if node.rules else str(node.policy)]
    if node.wait_for is not None:
        waited = ", ".join(node.wait_for) if isinstance(node.wait_for, list) else node.wait_for
        words.append(f"waits for {waited}")
    if node.cancel != "halt":
        words.append(node.cancel)
    return ", ".join(words)


def rule_text(rule: ParallelRule) -> str:
    """Return the conditions of a rule in a few words."""
    words = [f"{child}: {said if isinstance(said, str) else ' | '.join(said)}" for child, said in rule.when.items()]
    if rule.at_least is not None:
        words.append(f"{rule.at_least} × {rule.ends}")
    return ", ".join(words) or "else"


def links_of(node: Container) -> list[Link]:
    """Return the links among a container's children, those to what isn't there left out; the same ends are joined."""
    names = list(children_of(node))
    found: dict[tuple[str, str, bool], list[str]] = {}
    if isinstance(node, StateMachine):
        if node.initial in node.children:
            found["", node.initial, False] = []
        for name, child in node.children.items():
            for end, target in child.on.items():
                if target in node.children or target in node.outcomes:
                    found.setdefault((name, target, target not in node.children), []).append(end)
    else:
        if isinstance(node, Sequence | Fallback):
            label = "else" if isinstance(node, Fallback) else ""
            for name, following in zip(names, names[1:], strict=False):
                found[name, following, False] = [label] if label else []
        if isinstance(node, Switch):
            for name, literal in node.literals():
                if name in names:
                    found.setdefault(("", name, False), []).append(json.dumps(literal))
            if node.default in names:
                found.setdefault(("", node.default, False), []).append("else")
        for end, target in node.exits.items():
            name, _, label = end.partition(".")
            if name in names:
                found.setdefault((name, target, True), []).append(label)
    return [Link(s, t, ", ".join(labels), out) for (s, t, out), labels in found.items()]


def outcomes_shown(node: Container) -> dict[str, str]:
    """Return the outcomes that are drawn in a container, with their meanings: those that links lead to."""
    meanings: Mapping[str, str] = outcomes_of(node)
    declared = list(node.outcomes)
    used = [link.target for link in links_of(node) if link.to_outcome]
    return {name: meanings.get(name, "failure") for name in dict.fromkeys([*declared, *used])}
