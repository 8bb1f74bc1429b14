"""Graph -> py_trees tree, graph -> SMACH machine. Both are exact: a compiler refuses what it can't express.

`to_tree(task, catalog)` and `to_machine(task, catalog)` have one contract: `.data` holds the run's variables, `.leaves`
and `.by_path` what was made, `prepare(context)` sets up, `observe(observer)` reports, `execute(pacer)` runs to its end.
"""

from .behaviour_state import BehaviourState, Halted, Pacer, Rushing, TaskEnd, drive
from .to_machine import CompiledMachine, to_machine
from .to_tree import CompiledTree, to_tree

__all__ = [
    "BehaviourState",
    "CompiledMachine",
    "CompiledTree",
    "Halted",
    "Pacer",
    "Rushing",
    "TaskEnd",
    "drive",
    "to_machine",
    "to_tree",
]
