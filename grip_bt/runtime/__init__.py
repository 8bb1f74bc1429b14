"""Running compiled tasks: clock, context, runner, tick engine, journal, control.

* Ticking: `runner` (a run from beginning to end), `pacing` and `waker` (when to tick), `engine/` (py_trees trees as
  closures), `lockstep` (turns of a run and its simulated world), `watchdog` (ticks that don't end), `workers`.
* Stopping: `stopping`, `motions` and `rest` (what was told to stop is measured to rest), `pulse` (what the parent
  sees).
* Journal: `run_log` (the ticking thread) -> `journal_writer` (with `blocks`, `value_codec`) -> SQLite ->
  `journal_reader`.
* Control: `control` (over streams), `debugger`, `breakpoints`.
* Executing a recorded run again: `recording`, `reliving`, `relived_leaf`, `relived_clock`; `keeping`: state beside
  the task.
* Trees inside of SMACH machines: `tree_state`, `tree_choice`, `tree_containers`.
"""

from .clock import ManualClock, WallClock
from .context import RunContext, RunParts
from .control import serve_control
from .engine import TickEngine
from .journal import Journal, JournalError
from .journal_events import Event
from .journal_reader import JournalReader, RunRecord
from .moment import Moment, NodeState
from .pacing import Pacing
from .recording import Recording
from .reliving import Reliving, Result
from .run_log import RunLog
from .runner import Runner, RunResult
from .tree_choice import Choose
from .tree_containers import Each, Joining
from .tree_state import BehaviourTree, TreeRun
from .waker import Waker

__all__ = [
    "BehaviourTree",
    "Choose",
    "Each",
    "Event",
    "Joining",
    "Journal",
    "JournalError",
    "JournalReader",
    "ManualClock",
    "Moment",
    "NodeState",
    "Pacing",
    "TickEngine",
    "Recording",
    "Reliving",
    "Result",
    "RunContext",
    "RunParts",
    "RunLog",
    "RunRecord",
    "RunResult",
    "Runner",
    "TreeRun",
    "Waker",
    "WallClock",
    "serve_control",
]
