"""Running compiled tasks: clock, context, runner, tick engine, journal, control.

* Ticking: `runner` (a run from beginning to end), `pacing` and `clock` (when to tick), `engine` (trees of py_trees as
  closures), `lockstep` (turns of a run and its simulated world), `context` (also: workers).
* Stopping: `stopping` (also of ticks that don't end), `motion_end` (what was told to stop is measured to rest),
  `observers` (also: what the parent sees).
* Journal: `journal` (the ticking thread, then the writer's, with `base.value_codec`) -> SQLite -> `journal_reader`.
* Control: `control` (over streams), `debugger` (with breakpoints).
* Executing a recorded run again: `recording`, `re_execution`; `observers`: state beside the task.
* Trees inside of SMACH machines: `smach_states`.
"""

from grip_bt.runtime.journal_events import RunSnapshot as RunSnapshot

from .clock import WallClock as WallClock
from .context import RunContext as RunContext
from .context import RunParts as RunParts
from .control import serve_control as serve_control
from .engine import TickEngine as TickEngine
from .journal import Journal as Journal
from .journal import RunLog as RunLog
from .journal_events import Event as Event
from .journal_reader import JournalReader as JournalReader
from .journal_reader import RunRecord as RunRecord
from .journal_rows import JournalError as JournalError
from .re_execution import ReExecution as ReExecution
from .recording import Recording as Recording
from .result import RunResult as RunResult
from .runner import Runner as Runner
from .smach_states import BehaviourTree as BehaviourTree
from .smach_states import Choose as Choose
from .smach_states import TreeRun as TreeRun
