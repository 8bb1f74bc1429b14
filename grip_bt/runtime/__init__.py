"""Running compiled tasks: clock, context, runner, tick engine, journal, control.

* Ticking: `runner` (a run from beginning to end), `pacing` and `clock` (when to tick), `engine` (the same as
  closures), `lockstep` (turns of a run and its simulated world), `workers`.
* Stopping: `stopping` (also of ticks that don't end), `motion_end` (what was told to stop is measured to rest),
  `observers` (also: what the parent sees).
* Journal: `journal` (the ticking thread, then the writer's, with `value_codec`) -> SQLite -> `journal_reader`.
* Control: `control` (over streams), `debugger` (with breakpoints).
* Executing a recorded run again: `recording`, `re_execution`; `observers`: state beside the task.
* Trees inside of SMACH machines: `smach_states`.
"""

from grip_bt.runtime.journal_events import NodeState, RunSnapshot

from .clock import ManualClock, Waker, WallClock
from .context import RunContext, RunParts
from .control import serve_control
from .journal import Journal, RunLog
from .journal_events import Event
from .journal_reader import JournalReader, RunRecord
from .journal_rows import JournalError
from .pacing import Pacing
from .re_execution import ReExecution
from .recording import Recording
from .runner import Runner, RunResult
from .smach_states import BehaviourTree, Choose, TreeRun

__all__ = [
    "BehaviourTree",
    "Choose",
    "Event",
    "Journal",
    "JournalError",
    "JournalReader",
    "ManualClock",
    "RunSnapshot",
    "NodeState",
    "Pacing",
    "Recording",
    "ReExecution",
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
