"""Running compiled tasks: clock, context, runner, journal, control."""

from .clock import ManualClock, WallClock
from .context import RunContext
from .control import serve_control
from .journal import Journal, JournalError, RunLog
from .journal_reader import Event, JournalReader, RunRecord
from .moment import Moment, NodeState
from .pacing import Pacing
from .plan import Plan
from .runner import Runner, RunResult
from .waker import Waker

__all__ = [
    "Event",
    "Journal",
    "JournalError",
    "JournalReader",
    "ManualClock",
    "Moment",
    "NodeState",
    "Pacing",
    "Plan",
    "RunContext",
    "RunLog",
    "RunRecord",
    "RunResult",
    "Runner",
    "Waker",
    "WallClock",
    "serve_control",
]
