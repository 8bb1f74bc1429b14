"""Composites and decorators of a task: py_trees' own, with labelled ends, reasons, exits and the run's clock."""

from .composites import Fallback, Sequence
from .container import PLAIN, Container, Face
from .decorators import Force, Invert, Repeat, Retry, Timeout
from .dispatch import MAX_TRANSITIONS, Dispatch
from .edges import Edges
from .parallel import End, Parallel, decide, first_reason

__all__ = [
    "MAX_TRANSITIONS",
    "PLAIN",
    "Container",
    "Dispatch",
    "Edges",
    "End",
    "Face",
    "Fallback",
    "Force",
    "Invert",
    "Parallel",
    "Repeat",
    "Retry",
    "Sequence",
    "Timeout",
    "decide",
    "first_reason",
]
