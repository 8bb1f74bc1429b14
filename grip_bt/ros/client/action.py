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
from typing import Any

import numpy as np
from action_msgs.msg import GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_action_status_default
from rclpy.task import Future
from unique_identifier_msgs.msg import UUID

from grip_bt.base.failures import UnfitServerError
from grip_bt.base.operation import Operation

from ..watchdog import Guard
from .base import Request, ServedClient
from .connection import Connection
from .goal import LIVE, Command, Goal, GoalEnd, GoalTimeouts, Phase, RequestCancel, RequestResult, Send, Tell
from .graph import explained
from .server_check import GRACE, action_servers, check_action_servers
from .service import SERVICE_QOS
from .types import InterfaceType, Message

CANCEL = 3.0
"""How long a server may take to end a goal that was canceled [s]."""
_FEEDBACK_DEPTH = 10


@dataclass(eq=False)
class _Entry(Request):
    """A goal with what rclpy gave for it; without a message, somebody who only waits for the server."""

    machine: Goal = field(kw_only=True)
    on_feedback: Callable[[Message], None] | None = None
    on_accepted: Callable[[], None] | None = None
    guard: Guard | None = None
    servers: frozenset[bytes] = field(default_factory=frozenset)
    goal_id: bytes = b""  # when it is sent
    status: int = 0  # what the server last published of it, 0 when nothing
    result: Future | None = None
    futures: list[Future] = field(default_factory=list)


class ActionClient(ServedClient[_Entry]):
    """The client of one action; made by `Bus.action`."""

    def __init__(self, bus: Connection, type_: InterfaceType, name: str):
        super().__init__(
            bus,
            type_,
            name,
            lambda: action_servers(bus.node, name),
            lambda servers: check_action_servers(bus.node, type_, name, servers),
        )
        self._wire: ActionWire | None = None

    @property
    def idle(self) -> bool:
        """Whether it was never connected to a server and nobody waits for one; such a client may be replaced."""
        return self._wire is None and not self._requests

    @property
    def busy(self) -> bool:
        """Whether a server still has a goal of ours that nobody waits for, and hasn't answered that it stops."""
        return any(e.machine.phase in (Phase.ORPHANED, Phase.ORPHANED_SENT) for e in list(self._requests))

    # --- from any thread ---

    def send(
        self,
        goal: Message | None,
        timeout: float | None = None,
        wait: float | None = None,
        on_feedback: Callable[[Message], None] | None = None,
        cancel_within: float = CANCEL,
        on_accepted: Callable[[], None] | None = None,
        moves: bool = True,
        limit: str = "",
    ) -> Operation[GoalEnd]:
        """Send a goal; the result says how it ended: `succeeded`, `aborted` or `canceled`, with the result message.

        Cancelling the operation asks the server to cancel the goal; it then ends with what the server says, or with
        CanceledError when the server says nothing. Without a word of the server it ends with ServerLostError,
        UnfitServerError, ServerTimeOutError or GoalRejectedError. A goal that its owner no longer waits for is
        cancelled, also when that becomes possible only later.

        Args:
            goal: a message of `type.Goal`.
            timeout: how long it may take in all [s]; `math.inf` for ever.
            wait: how long to wait for the server to appear [s].
            on_feedback: called on the bus's thread with each feedback message; the last one is the operation's
                `progress`. What a server sends just before the result is often lost.
            cancel_within: how long the server may take to end the goal after a cancel [s].
            on_accepted: called on the bus's thread when the server has answered that it takes the goal.
            moves: whether it may move something; then the bus's guard, where there is one, ends it after our death.
            limit: who limits the time, in words behind those of a time-out.
        """
        now = time.monotonic()
        timeout = self._bus.timeout if timeout is None else timeout
        wait = self._bus.wait if wait is None else wait
        patience = GoalTimeouts(wait, timeout, cancel_within, GRACE if self._supervised else 0.0, limit)
        entry = _Entry(goal, now, now + timeout, now + wait, machine=Goal(self.name, patience, now))
        entry.on_feedback, entry.on_accepted = on_feedback, on_accepted
        entry.guard = self._bus.guard if moves and goal is not None else None
        return self._begin(entry)

    def wait_ready(self, timeout: float) -> Operation[None]:
        """End when there is a server that fits; with ServerLostError after `timeout` [s]."""
        return self.send(None, timeout + 1.0, timeout).then(lambda _: Operation.finished(None))

    # --- on the bus's thread ---

    def poll(self) -> bool:
        """Look at the goals under way; False when there are none."""
        now = time.monotonic()
        if any(e.machine.phase is not Phase.WAITING for e in self._requests):
            present = self._check.present()
            for entry in list(self._requests):
                if entry.servers:
                    self._do(entry, entry.machine.server_seen(bool(entry.servers & present), now))
                if entry.status:
                    self._do(entry, entry.machine.status(entry.status, now))
        self._advance(now)
        for entry in list(self._requests):
            self._do(entry, entry.machine.tick(now))
        return bool(self._requests)

    def end(self, error: Exception) -> None:
        """Tell every owner that the connection is being closed, and servers that their goals are canceled."""
        for entry in list(self._requests):
            self._do(entry, entry.machine.close(time.monotonic()))

    def _cancel(self, request: _Entry) -> None:
        self._do(request, request.machine.cancel(time.monotonic()))

    def _all_lost(self, reason: str) -> None:
        for entry in list(self._requests):
            self._do(entry, entry.machine.server_ended(reason))

    def _waiting(self) -> list[_Entry]:
        return [e for e in self._requests if e.machine.phase is Phase.WAITING]

    def _sent(self) -> int:
        return sum(e.machine.phase is Phase.SENT for e in self._requests)

    def _unfit(self, request: _Entry, error: UnfitServerError) -> None:
        self._do(request, request.machine.server_unfit(error))

    def _connected(self) -> bool:
        if self._wire is None:
            self._wire = ActionWire(self._bus.node, self.type, self.name, self._progressed, self._statuses)
        return self._wire.server_is_ready()

    def _do(self, entry: _Entry, commands: list[Command]) -> None:
        """Carry out what the machine of a goal says; forget the goal when it is over."""
        for command in commands:
            match command:
                case Send():
                    self._put_out(entry)
                case RequestResult():
                    if entry.result is not None:
                        entry.result.cancel()  # that request, or its answer, was dropped on the way
                    entry.result = self._connection.ask_result(entry.goal_id)
                    self._later(entry, entry.result, self._resulted)
                case RequestCancel():
                    self._later(entry, self._connection.ask_cancel(entry.goal_id), self._cancel_answered)
                case Tell(end):
                    entry.on_feedback = None
                    if isinstance(end, GoalEnd):
                        entry.operation.succeed(end)
                    else:
                        entry.operation.fail(explained(end, self._bus.node, self.type))
        if entry.machine.phase is Phase.OVER:
            self._drop(entry)

    def _drop(self, entry: _Entry) -> None:
        if entry in self._requests:
            self._requests.remove(entry)
            for future in entry.futures:
                future.cancel()  # which takes it out of rclpy's lists; nobody else would, and they would grow for ever
            entry.futures.clear()
            if entry.goal_id and entry.guard is not None:
                entry.guard.over(entry.goal_id)

    @property
    def _connection(self) -> ActionWire:
        """The connection of goals that were sent; it was made before them."""
        assert self._wire is not None
        return self._wire

    def _send(self, request: _Entry, now: float) -> None:
        self._do(request, request.machine.server_fits(now))

    def _put_out(self, entry: _Entry) -> None:
        entry.servers, entry.goal_id = self._check.servers, new_goal_id()
        if entry.guard is not None:
            entry.guard.sent(self.name, entry.goal_id)
        assert entry.message is not None
        try:
            future = self._connection.send_goal(entry.goal_id, entry.message)
        except Exception as error:  # noqa: BLE001 - rclpy's own errors and TypeErrors of a wrong goal
            self._do(entry, entry.machine.send_failed(error))
            return
        self._later(entry, future, self._goal_answered)

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
        if response.accepted and entry.on_accepted is not None:
            entry.on_accepted()
        self._do(entry, entry.machine.accepted(now) if response.accepted else entry.machine.rejected())
        self._advance(now)

    def _resulted(self, entry: _Entry, response: Message) -> None:
        self._do(entry, entry.machine.result(response.status, response.result))

    def _cancel_answered(self, entry: _Entry, response: Message) -> None:
        # Its return code is 0 also for a goal that the server refused to cancel; the list is what counts. "Terminated"
        # is said of goals that end already, too.
        codes = CancelGoal.Response
        stops = bool(response.goals_canceling) or response.return_code == codes.ERROR_GOAL_TERMINATED
        known = response.return_code != codes.ERROR_UNKNOWN_GOAL_ID
        now = time.monotonic()
        self._do(entry, entry.machine.cancel_answered(stops, known, now))
        self._advance(now)

    def _progressed(self, goal_id: bytes, feedback: Message) -> None:
        entry = next((e for e in self._requests if e.goal_id == goal_id), None)
        if entry is not None and entry.machine.phase in LIVE:
            entry.operation.report(feedback)
            if entry.on_feedback is not None:
                entry.on_feedback(feedback)

    def _statuses(self, message: GoalStatusArray) -> None:
        """Hear of goals from the server, also of such whose acceptance was lost."""
        known = {bytes(s.goal_info.goal_id.uuid): int(s.status) for s in message.status_list}
        for entry in [e for e in self._requests if e.goal_id in known]:
            entry.status = known[entry.goal_id]
            if entry.machine.phase in (Phase.SENT, Phase.ORPHANED_SENT):
                self._do(entry, entry.machine.status(entry.status, time.monotonic()))


class ActionWire:
    """Sends to and hears of the server of one action; answers are rclpy's futures.

    A future that is cancelled is forgotten, and its answer, if it comes, ignored.

    Args:
        node: the node it lives on.
        type_: the action's class.
        name: the action's full name.
        on_feedback: called on the executor's thread with a goal's id and the feedback message.
        on_status: called on the executor's thread with the statuses of the goals that the server remembers.
    """

    def __init__(
        self,
        node: Node,
        type_: InterfaceType,
        name: str,
        on_feedback: Callable[[bytes, Message], None],
        on_status: Callable[[GoalStatusArray], None],
    ):
        self._type, self._impl = type_, type_.Impl
        self._services = [
            node.create_client(kind, f"{name}/_action/{end}", qos_profile=SERVICE_QOS)
            for kind, end in (
                (self._impl.SendGoalService, "send_goal"),
                (self._impl.GetResultService, "get_result"),
                (CancelGoal, "cancel_goal"),
            )
        ]
        self._goals, self._results, self._cancels = self._services
        self._topics = [f"{name}/_action/feedback", f"{name}/_action/status"]
        self._node = node

        def heard(message: Message) -> None:
            on_feedback(bytes(message.goal_id.uuid), message.feedback)

        node.create_subscription(
            self._impl.FeedbackMessage,
            self._topics[0],
            heard,
            QoSProfile(depth=_FEEDBACK_DEPTH),
        )
        node.create_subscription(GoalStatusArray, self._topics[1], on_status, qos_profile_action_status_default)

    def server_is_ready(self) -> bool:
        """Tell whether there is a server, and all of its services are connected to us."""
        return all(s.service_is_ready() for s in self._services) and all(
            self._node.count_publishers(topic) for topic in self._topics
        )

    def send_goal(self, goal_id: bytes, goal: Message) -> Future:
        """Send a goal under a new id; the answer tells whether it is accepted.

        Raises:
            TypeError: it isn't a goal of this action.
        """
        if not isinstance(goal, self._type.Goal):
            raise TypeError(f"a goal of {self._type.__name__} has to be a {self._type.__name__}.Goal, not {goal!r}")
        return self._goals.call_async(self._impl.SendGoalService.Request(goal_id=_uuid(goal_id), goal=goal))

    def ask_result(self, goal_id: bytes) -> Future:
        """Ask for the result, to be sent when there is one; at once when the server doesn't know the goal."""
        return self._results.call_async(self._impl.GetResultService.Request(goal_id=_uuid(goal_id)))

    def ask_cancel(self, goal_id: bytes) -> Future:
        """Ask the server to cancel a goal, whether or not its acceptance came."""
        request = CancelGoal.Request()
        request.goal_info.goal_id = _uuid(goal_id)
        return self._cancels.call_async(request)


def new_goal_id() -> bytes:
    """Return an id that no other goal has, 16 bytes."""
    return uuid.uuid4().bytes


def _uuid(goal_id: bytes) -> Any:
    return UUID(uuid=np.frombuffer(goal_id, np.uint8))
