"""Keys that nobody may have written when a state reads them: the leaves are told."""

from __future__ import annotations

from collections.abc import Iterable

from grip_bt.task import FrozenDict, Leaf, children_of
from grip_bt.task.model import AnyNode


def marked(node: AnyNode, missing: set[str]) -> AnyNode:
    """Tell every leaf which of its inputs may be unwritten."""
    if isinstance(node, Leaf):
        unwritten = [port for port, variable in node.in_.items() if variable in missing and port != "position"]
        return node.model_copy(update={"with_": FrozenDict({"unwritten": unwritten})}) if unwritten else node
    children = {name: marked(child, missing) for name, child in children_of(node).items()}
    return node.model_copy(update={"children": FrozenDict(children)})


def nodes_of(node: AnyNode) -> Iterable[AnyNode]:
    """Yield a node and all below it."""
    yield node
    for child in children_of(node).values():
        yield from nodes_of(child)
