"""Task -> task in the other form, exact or left as it is with a note that says why; see docs/conversion.md."""

from grip_bt.compilers.restructure.conversion import to_state_machines as to_state_machines
from grip_bt.compilers.restructure.conversion import to_trees as to_trees
from grip_bt.compilers.restructure.subtasks import extracted as extracted

from .as_edit import expanded as expanded
from .result import Restructured as Restructured
from .result import to_text as to_text
