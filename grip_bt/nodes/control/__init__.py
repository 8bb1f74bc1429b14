"""Composites and decorators of a task: py_trees' own, with labelled ends, reasons, exits and the run's clock."""

from .adopted import Foreign
from .composites import Fallback, Sequence
from .condition import Condition, Conditional, conditional
from .container import PLAIN, Container, Face
from .decorators import Force, Invert, Repeat, Retry, Timeout
from .dispatch import MAX_TRANSITIONS, Dispatch
from .guard import Guard
from .parallel import End, Match, Parallel, Ruling, decide, first_reason
from .prompt import PromptParallel
from .subtask import Subtask

__all__ = [
    "MAX_TRANSITIONS",
    "PLAIN",
    "Condition",
    "Conditional",
    "Container",
    "Dispatch",
    "End",
    "Face",
    "Fallback",
    "Force",
    "Foreign",
    "Guard",
    "Invert",
    "Match",
    "Parallel",
    "PromptParallel",
    "Repeat",
    "Retry",
    "Ruling",
    "Sequence",
    "Subtask",
    "Timeout",
    "conditional",
    "decide",
    "first_reason",
]
