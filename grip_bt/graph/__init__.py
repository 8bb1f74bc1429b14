"""What a task is: frozen models, the text that they are read from and written to, and edits of both."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .canonical import dumps
from .document import Document, load, loads, read, read_text
from .formatting import fmt
from .frozen import FrozenDict
from .model import (
    FORMAT_VERSION,
    KINDS,
    AnyNode,
    Container,
    Cooldown,
    Fallback,
    Force,
    ForEach,
    Foreign,
    Guard,
    Invert,
    Leaf,
    Loop,
    Meaning,
    Name,
    Node,
    Parallel,
    ParallelRule,
    Repeat,
    Retry,
    Sequence,
    StateMachine,
    Subtask,
    Switch,
    Task,
    Timeout,
    Variable,
)
from .schema import schema
from .walking import cases_of, children_of, expressions_of, join, outcomes_of, walk, with_refusal

if TYPE_CHECKING:
    from .edit import Edited, History, apply, apply_to_document, command_of
    from .layout import Layout, load_layout, write_layout

_ON_DEMAND = {
    **dict.fromkeys(("Edited", "History", "apply", "apply_to_document", "command_of"), ".edit"),
    **dict.fromkeys(("Layout", "load_layout", "write_layout"), ".layout"),
}
"""What only editors need, and where it is: running a task doesn't load it."""


def __getattr__(name: str) -> Any:
    if name not in _ON_DEMAND:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_ON_DEMAND[name], __name__), name)


__all__ = [
    "AnyNode",
    "Container",
    "Cooldown",
    "Document",
    "Edited",
    "FORMAT_VERSION",
    "Fallback",
    "ForEach",
    "Force",
    "Foreign",
    "Subtask",
    "FrozenDict",
    "Guard",
    "History",
    "Invert",
    "KINDS",
    "Layout",
    "Leaf",
    "Loop",
    "Meaning",
    "Name",
    "Node",
    "Parallel",
    "ParallelRule",
    "Repeat",
    "Retry",
    "Sequence",
    "StateMachine",
    "Switch",
    "Task",
    "Timeout",
    "Variable",
    "apply",
    "apply_to_document",
    "cases_of",
    "children_of",
    "command_of",
    "dumps",
    "expressions_of",
    "fmt",
    "join",
    "load",
    "load_layout",
    "loads",
    "outcomes_of",
    "read",
    "read_text",
    "schema",
    "walk",
    "with_refusal",
    "write_layout",
]
