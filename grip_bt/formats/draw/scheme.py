"""What a drawing says about a task, before any geometry: words for nodes, and the links between children."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from grip_bt.task import KINDS, AnyNode, Container, Leaf, outcomes_of
from grip_bt.task.kind_analysis import links

View = Literal["tree", "flow"]
GLYPHS = {"leaf": "", **{name: kind.sign for name, kind in KINDS.items()}}
"""A sign per kind, for text; pictures draw theirs."""


@dataclass(frozen=True)
class Link:
    """A connection between two children, or from a child to an outcome of their container.

    Without a source it is the start of a state machine or a switch; without a label, order alone decides.
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
    return node.node if isinstance(node, Leaf) else node.words()


def details(node: AnyNode) -> list[str]:
    """Return further lines about a node: literals, and where its ends lead."""
    lines = [f"only if {node.precondition}"] if node.precondition else []
    if isinstance(node, Leaf) and node.with_:
        lines.append(", ".join(f"{name}={value}" for name, value in node.with_.items()))
    lines.extend(f"{label} → {target}" for label, target in node.on.items())
    if not isinstance(node, Leaf):
        lines.extend(node.lines())
        lines.extend(f"{end} ⇥ {target}" for end, target in node.exits.items())
    return lines


def links_of(node: Container) -> list[Link]:
    """Return the links among a container's children, those to what isn't there left out; the same ends are joined."""
    return [Link(s, t, ", ".join(labels), out) for (s, t, out), labels in links(node).items()]


def outcomes_shown(node: Container) -> dict[str, str]:
    """Return the outcomes that are drawn in a container, with their meanings: those that links lead to."""
    meanings: Mapping[str, str] = outcomes_of(node)
    declared = list(node.outcomes)
    used = [link.target for link in links_of(node) if link.to_outcome]
    return {name: meanings.get(name, "failure") for name in dict.fromkeys([*declared, *used])}
