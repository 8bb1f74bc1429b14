"""Nodes of a task under construction, as the keys of a file; and what SKIPPED becomes.

A node that BT.CPP may skip has the outcome `skipped`. It means success in a sequence and failure in a fallback, so that
both go on to the next child; every other container hands it up by `exits`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from grip_bt.formats.names import distinct
from grip_bt.task.catalog import Catalog

Keys = dict[str, Any]
SKIPPED = "skipped"
SUCCEED: Keys = {"node": "flow/succeed"}
FAIL: Keys = {"node": "flow/fail"}


@dataclass
class NodeDraft:
    """A node.

    Attributes:
        keys: of its entry in a file.
        skips: whether it has the outcome `skipped`.
        name: what it was called.
        instant: it ends in the tick in which it begins.
        label: the outcome that it has when it is skipped.
    """

    keys: Keys
    skips: bool = False
    name: str = ""
    instant: bool = False
    label: str = SKIPPED

    @property
    def can_fail(self) -> bool:
        """Whether it has the outcome `failure`: each does but for some leaves of GRIP's own."""
        node = self.keys.get("node", "")
        return "precondition" in self.keys or not _never_fails(str(node))


@cache
def _never_fails(node: str) -> bool:
    builtin = Catalog.builtin()
    return node in builtin and "failure" not in builtin.get(node).outcomes


@dataclass
class SkipHandling:
    """What `skipped` of a container means, and the ends of children that lead to it."""

    meaning: str
    ends: list[str] = field(default_factory=list)

    @classmethod
    def of(cls, meaning: str, children: Mapping[str, NodeDraft]) -> SkipHandling:
        """Return how the children that may be skipped are handed up."""
        return cls(meaning, [f"{name}.{child.label}" for name, child in children.items() if child.skips])

    def on(self, keys: Keys) -> Keys:
        """Return the container's keys with the outcome and the exits that lead to it."""
        if not self.ends:
            return keys
        exits = {**keys.get("exits", {}), **dict.fromkeys(self.ends, SKIPPED)}
        return {**keys, "outcomes": {**keys.get("outcomes", {}), SKIPPED: self.meaning}, "exits": exits}


def decorator(kind: str, child: NodeDraft, meaning: str, **more: Any) -> NodeDraft:
    """Return a decorator that hands up `skipped`."""
    name = distinct([child.name])[0]
    keys = {"kind": kind, **more, "child": {name: child.keys}}
    return NodeDraft(SkipHandling.of(meaning, {name: child}).on(keys), child.skips, child.name, child.instant)


def container(kind: str, children: Mapping[str, NodeDraft], up: SkipHandling | None = None, **more: Any) -> NodeDraft:
    """Return a composite; `up` says which children hand up `skipped`, the others go by its meaning."""
    keys = {"kind": kind, **more, "children": {name: child.keys for name, child in children.items()}}
    instant = all(child.instant for child in children.values())
    return NodeDraft(up.on(keys) if up else keys, bool(up and up.ends), instant=instant)


def named(children: list[NodeDraft]) -> dict[str, NodeDraft]:
    """Return siblings by names that a task may have."""
    return dict(zip(distinct([child.name for child in children]), children, strict=True))


def switch(
    on_value: str, cases: Mapping[str, Any], children: Mapping[str, NodeDraft], meaning: str, **more: Any
) -> NodeDraft:
    """Return a switch that hands up `skipped` of every child that has it."""
    return container(
        "switch", children, SkipHandling.of(meaning, children), on_value=on_value, cases=dict(cases), **more
    )


def skip() -> NodeDraft:
    """Return a node whose success is the container's being skipped."""
    return NodeDraft(dict(SUCCEED), True, "skip", True, "success")


def set_variable(variable: str, value: Any) -> NodeDraft:
    """Return a node that gives a variable a literal value."""
    return NodeDraft(
        {"node": "flow/set", "with": {"value": value}, "out": {"value": variable}}, name=f"set {variable}", instant=True
    )


def sequence_of(children: list[NodeDraft], name: str) -> NodeDraft:
    """Return nodes one after the other; one needs no sequence."""
    if len(children) == 1:
        return children[0]
    made = container("sequence", named(children))
    made.name = name
    return made
