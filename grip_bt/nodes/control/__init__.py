"""Composites and decorators of a task: py_trees' own, with labelled ends, reasons, exits and the run's clock."""

from .composites import Fallback, Sequence
from .condition import Condition, Conditional, conditional
from .container import PLAIN, Container, Face
from .decorators import Force, Invert, Repeat, Retry, Timeout
from .dispatch import MAX_TRANSITIONS, Dispatch
from .edges import Edges
from .guard import Guard
from .parallel import End, Parallel, decide, first_reason

__all__ = [
    "MAX_TRANSITIONS",
    "PLAIN",
    "Condition",
    "Conditional",
    "Container",
    "Dispatch",
    "Edges",
    "End",
    "Face",
    "Fallback",
    "Force",
    "Guard",
    "Invert",
    "Parallel",
    "Repeat",
    "Retry",
    "Sequence",
    "Timeout",
    "conditional",
    "decide",
    "first_reason",
]
