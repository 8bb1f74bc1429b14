"""Goals of one action over rclpy: checked before they are sent, watched until they end, never left behind.

What happens when is decided by `grip_bt.ros.client.goal`, one pure machine per goal; here its commands become calls
and the answers its events, all on the bus's thread.

An action is three services and two topics, https://design.ros2.org/articles/actions.html. They are used as such:
rclpy's own action client gives a handle of a goal only with the server's acceptance, which may be lost, and a goal
without one couldn't be cancelled.
"""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from action_msgs.msg import GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy.client import Client as RclpyClient
from rclpy.qos import QoSProfile, qos_profile_action_status_default
from rclpy.task import Future
from unique_identifier_msgs.msg import UUID

from grip_bt.base.operation import Operation

from ..watchdog import Watchdog
from .base import Request, ServedClient
from .goal import LIVE, ORPHANED, Ask, Command, Goal, GoalEnd, GoalTimeouts, Notify, Phase
from .graph import GRACE
from .service import SERVICE_QOS
from .types import Message

CANCEL = 3.0
"""How long a server may take to end a goal that was canceled [s]."""
_FEEDBACK_DEPTH = 10


@dataclass(eq=False)
class _Entry(Request):
    """A goal with what rclpy gave for it."""

    machine: Goal = field(init=False)  # when it is sent
    cancel_within: float = CANCEL
    on_feedback: Callable[[Message], None] | None = None
    watchdog: Watchdog | None = None
    goal_id: bytes = b""  # when it is sent
    status: int = 0  # what the server last published of it, 0 when nothing
    result: Future | None = None
    futures: list[Future] = field(default_factory=list)

    @property
    def uuid(self) -> UUID:
        """The goal's id as a message."""
        return UUID(uuid=np.frombuffer(self.goal_id, np.uint8))


class ActionClient(ServedClient[_Entry]):
    """The client of one action; made by `Bus.action`."""

    _new = _Entry
    _made: tuple[RclpyClient, ...] | None = None

    @property
    def busy(self) -> bool:
        """Whether a server still has a goal of ours that nobody waits for, and hasn't answered that it stops."""
        return any(e.machine.phase in ORPHANED for e in list(self._requests) if e.servers)

    @property
    def settled(self) -> bool:
        return not self._requests

    # --- from any thread ---

    def send(
        self,
        goal: Message,
        timeout: float | None = None,
        wait: float | None = None,
        on_feedback: Callable[[Message], None] | None = None,
        cancel_within: float = CANCEL,
        moves: bool = True,
        limit: str = "",
    ) -> Operation[GoalEnd]:
        """Send a goal; the result says how it ended: `succeeded`, `aborted` or `canceled`, with the result message.

        Cancelling the operation asks the server to cancel the goal; it then ends with what the server says, or with
        CanceledError when the server says nothing. Without a word of the server it ends with ServerLostError,
        IncompatibleServerError, ServerTimeOutError or GoalRejectedError. A goal that its owner no longer waits for is
        cancelled, also when that becomes possible only later.

        Args:
            timeout: how long it may take in all [s]; `math.inf` for ever.
            wait: how long to wait for the server to appear [s].
            on_feedback: called on the bus's thread with each feedback message; the last one is the operation's
                `progress`. What a server sends just before the result is often lost.
            cancel_within: how long the server may take to end the goal after a cancel [s].
            moves: whether it may move something; then the bus's watchdog, where there is one, ends it after our death.
            limit: who limits the time, in words behind those of a time-out.
        """
        entry = _Entry(goal, *self._times(timeout, wait), limit, cancel_within=cancel_within)
        entry.on_feedback = on_feedback
        entry.watchdog = self._bus.watchdog if moves else None
        return self._begin(entry)

    # --- on the bus's thread ---

    def end(self, error: Exception) -> None:
        """Notify every owner that the connection is being closed, and servers that their goals are canceled."""
        for entry in list(self._requests):
            if entry.servers:
                self._do(entry, entry.machine.close(time.monotonic()))
            else:
                self._finish(entry, error)

    def _look_after(self, request: _Entry, there: bool, now: float) -> None:
        self._do(request, request.machine.server_seen(there, now))
        if request.status:
            self._do(request, request.machine.status(request.status, now))
        self._do(request, request.machine.tick(now))

    def _cancel_sent(self, request: _Entry) -> None:
        self._do(request, request.machine.cancel(time.monotonic()))

    def _server_of_ended(self, request: _Entry, reason: str) -> None:
        self._do(request, request.machine.server_ended(reason))

    def _unanswered(self) -> int:
        return sum(e.machine.phase is Phase.SENT for e in self._requests if e.servers)

    def _connected(self) -> bool:
        """Connect: an answer is rclpy's future; one that is cancelled is forgotten, and its answer ignored."""
        node, impl = self._bus.node, self.type.Impl
        topics = feedback, status = [f"{self.name}/_action/{topic}" for topic in ("feedback", "status")]
        if self._made is None:
            self._made = tuple(
                node.create_client(kind, f"{self.name}/_action/{end}", qos_profile=SERVICE_QOS)
                for kind, end in (
                    (impl.SendGoalService, "send_goal"),
                    (impl.GetResultService, "get_result"),
                    (CancelGoal, "cancel_goal"),
                )
            )
            node.create_subscription(
                impl.FeedbackMessage, feedback, self._progressed, QoSProfile(depth=_FEEDBACK_DEPTH)
            )
            node.create_subscription(GoalStatusArray, status, self._statuses, qos_profile_action_status_default)
        return all(service.service_is_ready() for service in self._made) and all(
            node.count_publishers(topic) for topic in topics
        )

    def _do(self, entry: _Entry, commands: list[Command]) -> None:
        """Carry out what the machine of a goal says; forget the goal when it is over."""
        for command in commands:
            match command:
                case Ask.RESULT:
                    if entry.result is not None:
                        entry.result.cancel()  # that request, or its answer, was dropped on the way
                    _, results, _ = self._made or ()
                    entry.result = results.call_async(self.type.Impl.GetResultService.Request(goal_id=entry.uuid))
                    self._later(
                        entry, entry.result, lambda e, got: self._do(e, e.machine.result(got.status, got.result))
                    )
                case Ask.CANCEL:
                    _, _, cancels = self._made or ()
                    asked = CancelGoal.Request()
                    asked.goal_info.goal_id = entry.uuid
                    self._later(entry, cancels.call_async(asked), self._cancel_answered)
                case Notify(end):
                    entry.on_feedback = None
                    if isinstance(end, GoalEnd):
                        entry.operation.succeed(end)
                    else:
                        entry.operation.fail(end)
        if entry.machine.phase is Phase.OVER:
            self._drop(entry)

    def _drop(self, entry: _Entry) -> None:
        if entry in self._requests:
            self._requests.remove(entry)
            for future in entry.futures:
                future.cancel()  # which takes it out of rclpy's lists; nobody else would, and they would grow for ever
            entry.futures.clear()
            if entry.goal_id and entry.watchdog is not None:
                entry.watchdog.goal_ended(entry.goal_id)

    def _send(self, request: _Entry, now: float) -> None:
        grace = GRACE if self._supervised else 0.0
        patience = GoalTimeouts(request.deadline - request.began, request.cancel_within, grace, request.limit)
        request.machine, request.goal_id = Goal(self.name, patience, request.began, now), uuid.uuid4().bytes
        if request.watchdog is not None:
            request.watchdog.goal_sent(self.name, request.goal_id)
        goals, _, _ = self._made or ()
        try:
            if not isinstance(request.message, self.type.Goal):
                named = f"{self.type.__name__}.Goal"
                raise TypeError(f"a goal of {self.type.__name__} has to be a {named}, not {request.message!r}")
            asked = self.type.Impl.SendGoalService.Request(goal_id=request.uuid, goal=request.message)
            future = goals.call_async(asked)
        except Exception as error:  # noqa: BLE001 - rclpy's own errors and TypeErrors of a wrong goal
            self._do(request, request.machine.send_failed(error))
            return
        self._later(request, future, self._goal_answered)

    def _later(self, entry: _Entry, future: Future, then: Callable[[_Entry, Message], None]) -> None:
        """Call `then` with the future's result; futures that are given up are cancelled, and say nothing."""
        entry.futures.append(future)

        def ended(_: object) -> None:
            if future in entry.futures:
                entry.futures.remove(future)
            if future.cancelled() or entry.machine.phase is Phase.OVER:
                return
            error = future.exception()
            if error is not None:
                self._do(entry, entry.machine.server_ended(f"the client broke: {error}"))
            else:
                then(entry, future.result())

        future.add_done_callback(ended)

    def _goal_answered(self, entry: _Entry, response: Message) -> None:
        now = time.monotonic()
        self._do(entry, entry.machine.accepted(now) if response.accepted else entry.machine.rejected())
        self._advance(now)

    def _cancel_answered(self, entry: _Entry, response: Message) -> None:
        # Its return code is 0 also for a goal that the server refused to cancel; the list is what counts. "Terminated"
        # is said of goals that end already, too.
        codes = CancelGoal.Response
        stops = bool(response.goals_canceling) or response.return_code == codes.ERROR_GOAL_TERMINATED
        known = response.return_code != codes.ERROR_UNKNOWN_GOAL_ID
        now = time.monotonic()
        self._do(entry, entry.machine.cancel_answered(stops, known, now))
        self._advance(now)

    def _progressed(self, message: Message) -> None:
        goal_id = bytes(message.goal_id.uuid)
        entry = next((e for e in self._requests if e.goal_id == goal_id), None)
        if entry is not None and entry.machine.phase in LIVE:
            entry.operation.report(message.feedback)
            if entry.on_feedback is not None:
                entry.on_feedback(message.feedback)

    def _statuses(self, message: GoalStatusArray) -> None:
        """Hear of goals from the server, also of such whose acceptance was lost."""
        known = {bytes(s.goal_info.goal_id.uuid): int(s.status) for s in message.status_list}
        for entry in [e for e in self._requests if e.goal_id in known]:
            entry.status = known[entry.goal_id]
            if entry.machine.phase in (Phase.SENT, Phase.ORPHANED_SENT):
                self._do(entry, entry.machine.status(entry.status, time.monotonic()))
