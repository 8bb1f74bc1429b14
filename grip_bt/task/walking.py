"""The ways through a task: its nodes and their paths, and what each can end with or asks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from grip_bt.base.frozen import FrozenDict

from .model import AnyNode, Container, Leaf
from .parts import Meaning

_NONE: FrozenDict[str, AnyNode] = FrozenDict()


def children_of(node: AnyNode) -> FrozenDict[str, AnyNode]:
    """Return a node's children by name, in order; empty for a leaf."""
    return _NONE if isinstance(node, Leaf) else node.below


def join(parent: str, name: str) -> str:
    """Return the path of the child `name` of the node at `parent`.

    The root of a task has the path `/`, that of a subtask at `attempt/fetch` has `attempt/fetch/`, and its children
    `attempt/fetch/look`.
    """
    if parent == "/":
        return name
    return f"{parent}{name}" if parent.endswith("/") else f"{parent}/{name}"


def walk(node: AnyNode, path: str = "/") -> Iterator[tuple[str, AnyNode]]:
    """Yield every node below and including `node` with its path, parents first, in document order."""
    stack = [(path, node)]
    while stack:
        path, node = stack.pop()
        yield path, node
        stack.extend((join(path, name), child) for name, child in reversed(children_of(node).items()))


def outcomes_of(node: Container) -> dict[str, Meaning]:
    """Return every outcome that a container can end with, and its meaning; those of a subtask stand in its own file."""
    return with_refusal(node, node.all_outcomes())


def with_refusal(node: AnyNode, outcomes: Mapping[str, Meaning]) -> dict[str, Meaning]:
    """Return a node's outcomes and, where it has a precondition, the `failure` that it then may end with."""
    refusal: dict[str, Meaning] = {"failure": "failure"} if node.precondition else {}
    return {**outcomes, **{k: v for k, v in refusal.items() if k not in outcomes}}


def expressions_of(node: AnyNode) -> Iterator[tuple[str, str]]:
    """Yield the key and text of each expression of a node.

    A `precondition` sees the variables around the node, the others its own too.
    """
    if node.precondition:
        yield "precondition", node.precondition
    if not isinstance(node, Leaf):
        yield from node.expressions()
