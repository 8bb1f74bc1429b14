"""What a task is: frozen models, the text that they are read from and written to, and edits of both.

`model` and `parts` with `kinds/` (a kind of container a file: its fields, and what it does), `document` (text ->
task, with places), `shape` (what a document may hold, and its JSON Schema), `canonical` and `comments` (task -> text),
`edges`. `exploration` and `kind_analysis` find out what a kind can do. `edit/`, `catalog/`, `validation/`: each imports
only what stands before it.
"""

from grip_bt.base.frozen import FrozenDict
from grip_bt.task.model import children_of, expressions_of, join, outcomes_of, walk, with_refusal
from grip_bt.task.shape import schema

from .canonical import dumps, fmt
from .document import Document, load, loads, read, read_text
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

__all__ = [
    "AnyNode",
    "Container",
    "Cooldown",
    "Document",
    "FORMAT_VERSION",
    "Fallback",
    "ForEach",
    "Force",
    "Foreign",
    "Subtask",
    "FrozenDict",
    "Guard",
    "Invert",
    "KINDS",
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
    "children_of",
    "dumps",
    "expressions_of",
    "fmt",
    "join",
    "load",
    "loads",
    "outcomes_of",
    "read",
    "read_text",
    "schema",
    "walk",
    "with_refusal",
]
