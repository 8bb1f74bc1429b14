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
from .turns import Cases, Passes, Rule, Turn

__all__ = [
    "MAX_TRANSITIONS",
    "PLAIN",
    "Cases",
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
    "Passes",
    "PromptParallel",
    "Repeat",
    "Retry",
    "Rule",
    "Ruling",
    "Sequence",
    "Subtask",
    "Timeout",
    "Turn",
    "conditional",
    "decide",
    "first_reason",
]
