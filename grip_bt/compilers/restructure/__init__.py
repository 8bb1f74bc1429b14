"""Task -> task in the other form, exact or left as it is with a note that says why; see docs/conversion.md."""

from grip_bt.compilers.restructure.conversion import to_state_machines, to_trees
from grip_bt.compilers.restructure.subtasks import Extracted, extracted, inlined

from .as_edit import expanded
from .equivalence import Comparison, Difference, compare, moved, play
from .result import Note, Restructured, to_text

__all__ = [
    "Comparison",
    "Difference",
    "compare",
    "expanded",
    "Extracted",
    "extracted",
    "inlined",
    "moved",
    "Note",
    "play",
    "Restructured",
    "to_state_machines",
    "to_text",
    "to_trees",
]
