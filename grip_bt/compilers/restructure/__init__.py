"""Task -> task in the other form: composites as state machines, state machines as composites. Exact, or left as it is.

What is exact, and what has no equal in the other form and stays with a note that says why: docs/conversion.md.
"""

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
