"""A task under construction: its nodes, one in another.

A node that BT.CPP may skip has the outcome `skipped`. It means success in a sequence and failure in a fallback, so that
both go on to the next child; every other container hands it up by `exits`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
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
    """A node; `skips`: it has the outcome `skipped`, or what `label` calls it; `instant`: it ends in its first tick."""

    keys: Keys
    skips: bool = False
    name: str = ""
    instant: bool = False
    label: str = SKIPPED

    def may(self, outcome: str) -> bool:
        """Tell whether it has an outcome of BT.CPP's: each does but for some leaves of GRIP's own."""
        node = str(self.keys.get("node", ""))
        return (outcome == "failure" and "precondition" in self.keys) or outcome not in _lacking(node)


@cache
def _lacking(node: str) -> frozenset[str]:
    builtin = Catalog.builtin()
    return frozenset({"success", "failure"} - builtin.get(node).outcomes.keys() if node in builtin else ())


def _handing_up(keys: Keys, children: Mapping[str, NodeDraft], meaning: str) -> NodeDraft:
    ends = [f"{name}.{child.label}" for name, child in children.items() if child.skips and meaning]
    if ends:
        keys |= {"outcomes": {SKIPPED: meaning}, "exits": dict.fromkeys(ends, SKIPPED)}
    return NodeDraft(keys, bool(ends), instant=all(child.instant for child in children.values()))


def decorator(kind: str, child: NodeDraft, meaning: str, **more: Any) -> NodeDraft:
    """Return a decorator that hands up `skipped`."""
    name = distinct([child.name])[0]
    made = _handing_up({"kind": kind, **more, "child": {name: child.keys}}, {name: child}, meaning)
    made.name = child.name
    return made


def container(kind: str, children: Mapping[str, NodeDraft], meaning: str = "", **more: Any) -> NodeDraft:
    """Return a composite that hands up `skipped`, which means `meaning`; without one its children's own counts."""
    keys = {"kind": kind, **more, "children": {name: child.keys for name, child in children.items()}}
    return _handing_up(keys, children, meaning)


def controlled(decider: NodeDraft, children: list[NodeDraft], meaning: str) -> NodeDraft:
    """Return a control node; the leaf that decides is skipped where a child may be, or where it may be anyway."""
    parts = [NodeDraft(child.keys, False, child.name) for child in children]
    skips = decider.skips or any(child.skips for child in children)
    decides = NodeDraft(decider.keys, skips, "decide")
    return container("control", named([decides, *parts]), meaning or "success")


def failing(name: str, child: NodeDraft) -> NodeDraft:
    """Return a node that fails when its child has ended."""
    return NodeDraft({"kind": "force", "as": "failure", "child": {name: child.keys}}, instant=child.instant)


def named(children: list[NodeDraft]) -> dict[str, NodeDraft]:
    """Return siblings by names that a task may have."""
    return dict(zip(distinct([child.name for child in children]), children, strict=True))


def switch(
    on_value: str, cases: Mapping[str, object], children: Mapping[str, NodeDraft], meaning: str, **more: object
) -> NodeDraft:
    """Return a switch that hands up `skipped` of every child that has it."""
    return container("switch", children, meaning, on_value=on_value, cases=dict(cases), **more)


def skip() -> NodeDraft:
    """Return a node whose success is the container's being skipped."""
    return NodeDraft(dict(SUCCEED), True, "skip", True, "success")


def set_variable(variable: str, value: object) -> NodeDraft:
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


_TYPES = {"bool": "bool", "double": "float", "float": "float", "string": "str"}
_TYPES |= {"BT::StringView": "str", "string_view": "str"}
_INTEGER = re.compile("((un)?signed )?(int|long|short|char|long int|long long)|unsigned|u?int(8|16|32|64)_t|size_t")


def type_named(cpp: str) -> str:
    """Return the type that a port's C++ type is here; `Any` for every other."""
    text = cpp.strip().removeprefix("const ").rstrip("& ").removeprefix("std::").removeprefix("__cxx11::")
    if _INTEGER.fullmatch(text) and text != "char":
        return "int"
    return _TYPES.get("string" if text.startswith("basic_string") else text, "Any")
