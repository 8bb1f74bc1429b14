"""Composites and decorators of a task: py_trees' own, with labelled ends, reasons, exits and the run's clock."""

from .adopted import Foreign
from .chooser import Chooser, Cooldown, ForEach, Loop, Switch
from .composites import Fallback, Sequence
from .condition import Condition, Conditional, conditional
from .container import PLAIN, Container, Face
from .decorators import Force, Invert, Repeat, Retry, Timeout
from .dispatch import MAX_TRANSITIONS, Dispatch
from .guard import Guard
from .parallel import End, Match, Parallel, Ruling, decide, first_reason
from .prompt import PromptParallel, ReactiveSwitch
from .subtask import Subtask
from .turns import Cases, Items, Passes, Rest, Rule, Turn

__all__ = [
    "MAX_TRANSITIONS",
    "PLAIN",
    "Cases",
    "Chooser",
    "Condition",
    "Conditional",
    "Container",
    "Cooldown",
    "Dispatch",
    "End",
    "Face",
    "Fallback",
    "ForEach",
    "Force",
    "Foreign",
    "Guard",
    "Invert",
    "Items",
    "Loop",
    "Match",
    "Parallel",
    "Passes",
    "PromptParallel",
    "ReactiveSwitch",
    "Repeat",
    "Rest",
    "Retry",
    "Rule",
    "Ruling",
    "Sequence",
    "Subtask",
    "Switch",
    "Timeout",
    "Turn",
    "conditional",
    "decide",
    "first_reason",
]
