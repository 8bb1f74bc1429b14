"""Whether a task has come back as it was: the first thing that hasn't, by name."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from typing import Any

from grip_bt.base.expression import parse_expression
from grip_bt.task import model, walking

_EXPRESSIONS = ("precondition", "on_value")


@dataclass(frozen=True)
class Difference:
    """Something that isn't the same: where, what, and how."""

    path: str
    what: str
    why: str


def difference(task: model.Task, back: model.Task) -> Difference | None:
    """Return the first difference between a task and what came back; its `doc` is a comment, and may be lost."""
    one, other = dict(walking.walk(task.root)), dict(walking.walk(back.root))
    for path, node in one.items():
        if path not in other:
            return Difference(path, "its name or place", "it comes back under another")
        found = _of_node(path, node, other[path])
        if found is not None:
            return found
    for path in other:
        if path not in one:
            return Difference(path, "an additional node", "it comes back with it")
    for kind in ("inputs", "data"):
        found = _variables(kind, getattr(task, kind), getattr(back, kind))
        if found is not None:
            return found
    return None


def _of_node(path: str, node: model.AnyNode, other: model.AnyNode) -> Difference | None:
    if type(node) is not type(other):
        return Difference(path, f"a {_kind(node)}", f"it comes back as a {_kind(other)}")
    for name in type(node).model_fields:
        a, b = getattr(node, name), getattr(other, name)
        if name in ("children", "child"):
            a, b = list(a), list(b)
        if name in _EXPRESSIONS:
            a, b = _unparsed(a), _unparsed(b)
        if a != b and not (name == "order"):
            return Difference(path, f"`{name.rstrip('_')}`", f"{a!r} comes back as {b!r}")
    return None


def _kind(node: model.AnyNode) -> str:
    return getattr(node, "kind", "leaf")


def _unparsed(text: str) -> str:
    return ast.unparse(parse_expression(text).tree) if text else ""


def _variables(kind: str, said: Any, back: Any) -> Difference | None:
    for name, variable in said.items():
        if name not in back:
            return Difference("/", f"the variable {name!r}", "no node uses it, or only in another way")
        one, other = (v if isinstance(v, str) else v.type for v in (variable, back[name]))
        if one != other:
            return Difference("/", f"the type of the variable {name!r}", f"{one} comes back as {other}")
    extra = [name for name in back if name not in said]
    return Difference("/", f"the variable {extra[0]!r}", f"it comes back among the {kind}") if extra else None
