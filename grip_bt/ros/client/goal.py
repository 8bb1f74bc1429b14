"""The life of a goal that was sent, as a pure state machine: events in, commands out; no ROS, no thread, no clock.

    SENT --accepted--> RUNNING --cancel--> CANCELING --result--> OVER
      |                   |                    |
      +--- the owner was told something else --+--> ORPHANED_SENT, ORPHANED --> OVER

The owner of a goal is told exactly once how it ended, and never later than its patience allows. A goal whose time is
over is cancelled, and its owner told of the time-out when the server has said that it ended: nothing else may begin
before. What the server may still work on when its owner has been told (a cancel that nobody answered) is *orphaned*:
it is cancelled, by its id, and again until the server answers, so that nothing goes on moving for nobody; what its
owner is told says that it isn't known to have stopped.

The server's acceptance may be lost, for instance when the server doesn't know our ear yet. So a goal is accepted, too,
when the server publishes its status or agrees to cancel it; and it is cancelled although nobody knows whether it was
accepted. `grip_bt.ros.client.action` drives this machine with rclpy.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Literal

from grip_bt.base.failures import CanceledError, ExpectedError, GoalRejectedError, ServerLostError, ServerTimeOutError
from grip_bt.base.operation import STOPPED

from .types import Message

Status = Literal["succeeded", "aborted", "canceled"]
STATUSES: dict[int, Status] = {4: "succeeded", 5: "canceled", 6: "aborted"}
"""`action_msgs/msg/GoalStatus` of goals that have ended."""
RECANCEL = 0.5
"""After which time without an answer a cancel request is sent again [s]."""
REASK = 0.5
"""How long the result may take after the server published that the goal has ended, until it is asked for again [s]:
a server keeps the last 10 requests and drops others silently."""
NEVER_CAME = 30.0
"""For how long a server must say that it doesn't know an orphaned goal until it is believed [s]: it may have it in
hand, not taken yet."""
FORGET = 10.0
"""How long an orphaned goal is kept after its server was last seen [s]: the machine may only be busy."""


class Phase(Enum):
    """Where a goal is."""

    SENT = "sent"
    RUNNING = "running"
    CANCELING = "asked to stop"
    ORPHANED_SENT = "sent, for nobody"
    ORPHANED = "running, for nobody"
    OVER = "over"


LIVE = frozenset({Phase.SENT, Phase.RUNNING, Phase.CANCELING})
"""Phases in which the server has the goal and the owner waits."""
ORPHANED = frozenset({Phase.ORPHANED_SENT, Phase.ORPHANED})
"""Those in which the server has it, and the owner was told of its end."""


@dataclass(frozen=True)
class GoalTimeouts:
    """How long to wait [s].

    Attributes:
        result: for the result, in all; `math.inf` for ever.
        cancel: for the end, after a cancel.
        gone: before a server that isn't seen any more is lost.
        limit: who says how long the result may take, in words behind those of a time-out.
    """

    result: float = 30.0
    cancel: float = 3.0
    gone: float = 0.0
    limit: str = ""


@dataclass(frozen=True)
class GoalEnd:
    """How the server says that a goal ended.

    Attributes:
        result: the result message; often with nothing in it unless it succeeded.
    """

    status: Status
    result: Message


class Ask(Enum):
    """What the server is asked: for the result when there is one, to cancel the goal."""

    RESULT = "result"
    CANCEL = "cancel"


@dataclass(frozen=True)
class Notify:
    """Notify the owner how it ended: the server's word, or an error."""

    end: GoalEnd | Exception


Command = Ask | Notify


class Goal:
    """One goal. Each event returns what is to be done now, in order.

    Args:
        began: when its time began [s], of the same clock as in every event.
        now: when it is sent [s].

    Attributes:
        refused: whether the server refused to cancel it, so that it goes on although its owner is gone.
    """

    def __init__(self, name: str, patience: GoalTimeouts, began: float, now: float):
        self.name, self.patience = name, patience
        self.phase, self.refused = Phase.SENT, False
        self._began = began
        self._cancel_since: float | None = None
        self._late: Exception | None = None  # what the owner is told when a goal whose time is over has ended
        self._sent = now
        self._asked: float | None = None  # when the last cancel request was sent, None when it was answered
        self._unknown_since: float | None = None  # since when the server says that it doesn't know an orphaned goal
        self._gone_since: float | None = None
        self._ended_since: float | None = None

    def server_seen(self, present: bool, now: float) -> list[Command]:
        """The server that has the goal is there, or isn't; to be said at every look."""
        if present:
            self._gone_since = None
        elif self._gone_since is None:
            self._gone_since = now
        if self._gone_since is None:
            return []
        absent = now - self._gone_since
        if self.phase in LIVE and absent >= self.patience.gone:
            return self._let_go(self._lost("the action server disappeared while executing the goal"))
        if self.phase in ORPHANED and absent >= FORGET:
            self.phase = Phase.OVER
        return []

    def server_ended(self, reason: str) -> list[Command]:
        """The server's process is known to have ended, and every goal with it."""
        if self.phase in (*ORPHANED, Phase.OVER):
            self.phase = Phase.OVER
            return []
        return self._notify(self._lost(reason), Phase.OVER)

    # --- the server answers ---

    def send_failed(self, error: Exception) -> list[Command]:
        """The goal couldn't be sent, or isn't taken."""
        if self.phase is Phase.ORPHANED_SENT:
            self.phase = Phase.OVER
            return []
        return self._notify(error, Phase.OVER) if self.phase is Phase.SENT else []

    def accepted(self, now: float) -> list[Command]:
        """The server took the goal: it answered so, or what else it says of the goal shows it."""
        if self.phase is Phase.SENT:
            if self._cancel_since is None:
                self.phase = Phase.RUNNING
                return [Ask.RESULT]
            self.phase = Phase.CANCELING
            return [Ask.RESULT, *self._ask_cancel(now)]
        if self.phase is Phase.ORPHANED_SENT:
            self.phase = Phase.ORPHANED
            return self._ask_cancel(now)
        return []

    def rejected(self) -> list[Command]:
        """The server doesn't take the goal."""
        if self._cancel_since is not None:
            return self.send_failed(self._late or self._canceled("canceled, and rejected by the server"))
        return self.send_failed(GoalRejectedError(f"{self.name}: the server rejected the goal", server=self.name))

    def result(self, status: int, result: Message) -> list[Command]:
        """The server sent the result; a number that isn't an end means that it doesn't know the goal."""
        if self.phase not in (Phase.RUNNING, Phase.CANCELING, Phase.ORPHANED):
            return []
        if self.phase is Phase.ORPHANED:
            self.phase = Phase.OVER
            return []
        if status not in STATUSES:
            return self._notify(self._lost("the server doesn't know the goal any more; was it restarted?"), Phase.OVER)
        return self._notify(self._late or GoalEnd(STATUSES[status], result), Phase.OVER)

    def status(self, status: int, now: float) -> list[Command]:
        """What the server publishes of the goal; to be said at every look. The result comes by another way, or not."""
        if self.phase in (Phase.SENT, Phase.ORPHANED_SENT):
            return self.accepted(now)  # only goals that were taken have a status
        if self.phase not in (Phase.RUNNING, Phase.CANCELING) or status not in STATUSES:
            return []
        if self._ended_since is None:
            self._ended_since = now
        elif now >= self._ended_since + REASK:
            self._ended_since = now
            return [Ask.RESULT]
        return []

    def cancel_answered(self, stops: bool, known: bool, now: float) -> list[Command]:
        """The server answered the request to cancel. It counts for the owner only when the result comes.

        Args:
            stops: whether the goal will end, or has ended.
            known: whether the server knows the goal; if it doesn't, the goal may still be under way to it.
        """
        if self.phase in (Phase.SENT, Phase.ORPHANED_SENT) and not known:
            if self.phase is Phase.ORPHANED_SENT:  # given up when it hasn't been known for long; asked on until then
                self._unknown_since = now if self._unknown_since is None else self._unknown_since
                if now >= self._unknown_since + NEVER_CAME:
                    self.phase = Phase.OVER
            return []
        self._asked, self.refused = None, not stops
        if self.phase is Phase.SENT:
            self.phase = Phase.CANCELING
            return [Ask.RESULT]
        if self.phase in ORPHANED:
            self.phase = Phase.OVER
        return []

    # --- the owner, and time ---

    def cancel(self, now: float) -> list[Command]:
        return self._stop(now) if self._cancel_since is None and self.phase in LIVE else []

    def _stop(self, now: float) -> list[Command]:
        self._cancel_since = now
        if self.phase is Phase.RUNNING:
            self.phase = Phase.CANCELING
            return self._ask_cancel(now)
        return self._ask_again(now)

    def close(self, now: float) -> list[Command]:
        if self.phase in LIVE:
            return [*self._let_go(self._canceled("the connection to ROS was closed")), *self.tick(now)]
        return []

    def tick(self, now: float) -> list[Command]:
        if self.phase in LIVE and self._cancel_since is None and now >= self._began + self.patience.result:
            what = "the server did not accept the goal" if self.phase is Phase.SENT else "no result"
            self._late = self._timed_out(what)
            return self._stop(now)
        if self.phase in LIVE and self._cancel_since is not None and now >= self._cancel_since + self.patience.cancel:
            return [*self._let_go(self._unanswered()), *self.tick(now)]
        return self._ask_again(now)

    def _ask_again(self, now: float) -> list[Command]:
        if self.phase is Phase.CANCELING:
            due = self._asked is not None and now >= self._asked + RECANCEL
        elif self.phase is Phase.SENT:  # the acceptance may be lost; a cancel that overtakes the goal does nothing
            since = self._sent if self._asked is None else self._asked
            due = self._cancel_since is not None and now >= since + RECANCEL
        else:
            orphaned = self.phase in ORPHANED
            due = orphaned and (self._asked is None or now >= self._asked + RECANCEL)
        return self._ask_cancel(now) if due else []

    def _unanswered(self) -> ExpectedError:
        """Return what the owner is told of a goal that wasn't said to have ended in its time."""
        what = "the server refused to stop" if self.refused else "the server did not confirm the cancelling"
        if self._late is None:
            return CanceledError(f"{self.name}: canceled, but {what}", server=self.name, **{STOPPED: False})
        return ServerTimeOutError(f"{self._late}, and {what}", server=self.name, **{STOPPED: False})

    # --- parts ---

    def _notify(self, end: GoalEnd | Exception, phase: Phase) -> list[Command]:
        self.phase = phase
        return [Notify(end)]

    def _let_go(self, error: Exception) -> list[Command]:
        """Notify the owner, and keep the goal until the server knows that nobody waits."""
        if self.phase is Phase.SENT:
            self._asked = None  # to be asked at once: the goal may have got there meanwhile
            return self._notify(error, Phase.ORPHANED_SENT)
        told = self.phase is Phase.CANCELING and self._asked is None  # it has answered a cancel request already
        return self._notify(error, Phase.OVER if told else Phase.ORPHANED)

    def _ask_cancel(self, now: float) -> list[Command]:
        self._asked = now
        return [Ask.CANCEL]

    def _lost(self, reason: str) -> ServerLostError:
        return ServerLostError(f"{self.name}: {reason}", server=self.name)

    def _canceled(self, reason: str) -> CanceledError:
        return CanceledError(f"{self.name}: {reason}", server=self.name)

    def _timed_out(self, what: str) -> ServerTimeOutError:
        said = f"{self.name}: {what} after {self.patience.result:.1f} s{self.patience.limit}"
        return ServerTimeOutError(said, server=self.name)
