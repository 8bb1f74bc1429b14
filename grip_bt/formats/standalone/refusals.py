"""What a stand-alone file can't hold is refused by name."""

from __future__ import annotations

from typing import Any

from grip_bt.base.errors import NotExpressibleError
from grip_bt.task import model, walking

TARGET = "a stand-alone py_trees file"
_COMMON = {"doc", "precondition", "on", "x"}
_CONTAINER = {*_COMMON, "kind", "data", "outcomes"}
_KNOWN: dict[type[Any], set[str]] = {
    model.Leaf: {*_COMMON, "node", "with_", "in_", "out", "meaning"},
    model.Sequence: {*_CONTAINER, "children", "exits", "memory"},
    model.Fallback: {*_CONTAINER, "children", "exits", "memory"},
    model.Parallel: {*_CONTAINER, "children", "exits", "policy", "cancel", "order", "rules", "wait_for", "retick"},
    model.Switch: {*_CONTAINER, "children", "exits", "on_value", "cases", "default"},
    model.ForEach: {*_CONTAINER, "child", "exits", "items", "item"},
    model.Loop: {*_CONTAINER, "child", "exits", "while_", "times"},
    model.Cooldown: {*_CONTAINER, "child", "exits", "seconds"},
    model.StateMachine: {*_CONTAINER, "initial", "children"},
    model.Retry: {*_CONTAINER, "child", "exits", "times"},
    model.Repeat: {*_CONTAINER, "child", "exits", "times"},
    model.Timeout: {*_CONTAINER, "child", "exits", "seconds", "child_first"},
    model.Guard: {*_CONTAINER, "child", "exits", "if_"},
    model.Foreign: {*_COMMON, "kind", "behaviour", "args"},
    model.Invert: {*_CONTAINER, "child", "exits"},
    model.Force: {*_CONTAINER, "child", "exits", "as_"},
}


def refuse_unknown(task: model.Task) -> None:
    """Refuse kinds of nodes, and settings of them, that this export has no words for.

    Raises:
        NotExpressibleError: for the first one.
    """
    for path, node in walking.walk(task.root):
        kind = getattr(node, "kind", "leaf")
        known = _KNOWN.get(type(node))
        if known is None:
            raise NotExpressibleError(path, f"a {kind}", TARGET)
        for name, field in type(node).model_fields.items():
            if name not in known and getattr(node, name) != field.get_default(call_default_factory=True):
                raise NotExpressibleError(path, f"`{field.alias or name}` of a {kind}", TARGET)
        if getattr(node, "cancel", "halt") not in ("halt", "join"):
            raise NotExpressibleError(path, f"`cancel: {getattr(node, 'cancel', '')}` of a {kind}", TARGET)
