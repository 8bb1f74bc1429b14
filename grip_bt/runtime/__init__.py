"""Running compiled tasks: clock, context, runner, journal, control."""

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
