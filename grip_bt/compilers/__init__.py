"""Graph -> py_trees tree, graph -> SMACH machine. Both are exact: a compiler refuses what it can't express.

`to_tree(task, catalog)` and `to_machine(task, catalog)` have one contract: `.data` holds the run's variables, `.leaves`
and `.by_path` what was made, `prepare(context)` sets up, `observe(observer)` reports, `execute(pacer)` runs to its end.
"""

from .behaviour_state import BehaviourState as BehaviourState
from .behaviour_state import Halted as Halted
from .behaviour_state import Pacer as Pacer
from .behaviour_state import Rushing as Rushing
from .behaviour_state import TaskEnd as TaskEnd
from .behaviour_state import drive as drive
from .to_machine import CompiledMachine as CompiledMachine
from .to_machine import to_machine as to_machine
from .to_tree import CompiledTree as CompiledTree
from .to_tree import to_tree as to_tree
