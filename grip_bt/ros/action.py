"""Goals of one action over rclpy: checked before they are sent, watched until they end, never left behind.

What happens when is decided by `grip_bt.ros.goal`, one pure machine per goal; here its commands become rclpy's calls
and rclpy's answers its events, all on the bus's thread.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from action_msgs.srv import CancelGoal

from grip_bt.base.failures import CanceledError, ServerLostError, UnfitServerError
from grip_bt.base.operation import Operation

from .action_wire import ActionWire, new_goal_id, status_in
from .client import pass_error
from .futures import give_way, when_done
from .goal import LIVE, AskCancel, AskResult, Command, Goal, GoalEnd, Patience, Phase, Send, Tell
from .others import explained
from .preflight import action_servers, check_action_servers
from .server_check import GRACE, STALE, ServerCheck

if TYPE_CHECKING:
    from .bus import Bus
    from .reaping import Guard

IN_FLIGHT = 8
"""Goals sent and not yet answered at once: a server keeps the last 10 requests and drops others without a word."""
CANCEL = 3.0
"""How long a server may take to end a goal that was canceled [s]."""


class _Entry:
    """A goal with what rclpy gave for it; without a message, somebody who only waits for the server."""

    def __init__(
        self, machine: Goal, message: Any, operation: Operation[Any], on_feedback: Callable[[Any], None] | None
    ):
        self.machine, self.message, self.operation, self.on_feedback = machine, message, operation, on_feedback
        self.guard: Guard | None = None
        self.on_accepted: Callable[[], None] | None = None
        self.began = time.monotonic()
        self.servers: frozenset[bytes] = frozenset()
        self.goal_id = b""  # when it is sent
        self.status = 0  # what the server last published of it, 0 when nothing
        self.result: Any = None
        self.futures: list[Any] = []


class ActionClient:
    """The client of one action; made by `Bus.action`.

    Attributes:
        type: the action's class.
        name: its full name.
        limit: who limits the time of a goal, in words behind those of a time-out.
    """

    limit = ""

    def __init__(self, bus: Bus, type_: Any, name: str, timeout: float, wait: float):
        self.type, self.name = type_, name
        self._bus, self._timeout, self._wait = bus, timeout, wait
        self._wire: ActionWire | None = None
        self._entries: list[_Entry] = []
        self._check = ServerCheck(
            lambda: action_servers(bus.node, name),
            lambda servers: check_action_servers(bus.node, type_, name, servers),
            self._connected,
        )
        self._server_ended: str | None = None
        self._supervised = False

    @property
    def idle(self) -> bool:
        """Whether it was never connected to a server and nobody waits for one; such a client may be replaced."""
        return self._wire is None and not self._entries

    @property
    def waiting(self) -> bool:
        """Whether somebody waits for the server to appear."""
        return any(e.machine.phase is Phase.WAITING for e in self._entries)

    @property
    def busy(self) -> bool:
        """Whether a server still has a goal of ours that nobody waits for, and hasn't answered that it stops."""
        return any(e.machine.phase in (Phase.LOOSE, Phase.LOOSE_SENT) for e in list(self._entries))

    # --- from any thread ---

    def send(
        self,
        goal: Any,
        timeout: float | None = None,
        wait: float | None = None,
        on_feedback: Callable[[Any], None] | None = None,
        cancel_within: float = CANCEL,
        on_accepted: Callable[[], None] | None = None,
        moves: bool = True,
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
        """
        limit = timeout if timeout is not None else self._timeout
        wait = self._wait if wait is None else wait
        guard = self._bus.guard if moves else None
        return self._begin(goal, limit, wait, on_feedback, cancel_within, on_accepted, guard)

    def wait_ready(self, timeout: float) -> Operation[None]:
        """End when there is a server that fits; with ServerLostError after `timeout` [s]."""
        return self._begin(None, timeout + 1.0, timeout, None, CANCEL)

    def server_ended(self, reason: str) -> None:
        """Say that the server's process is known to have ended: every goal fails at once, now and until it is back."""

        def end() -> None:
            self._server_ended = reason
            self._check.forget()
            for entry in list(self._entries):
                self._do(entry, entry.machine.server_ended(reason))

        self._bus.post(end)

    def server_started(self) -> None:
        """Say that the server's process was started by us, so that `server_ended` will tell its end."""

        def start() -> None:
            self._server_ended, self._supervised = None, True

        self._bus.post(start)

    def _begin(
        self,
        message: Any,
        timeout: float,
        wait: float,
        on_feedback: Callable[[Any], None] | None,
        cancel_within: float,
        on_accepted: Callable[[], None] | None = None,
        guard: Guard | None = None,
    ) -> Operation[Any]:
        def cancel() -> None:
            self._bus.post(lambda: self._do(entry, entry.machine.cancel(time.monotonic())))

        operation: Operation[Any] = Operation(on_cancel=cancel)
        patience = Patience(wait, timeout, cancel_within, GRACE if self._supervised else 0.0, self.limit)
        entry = _Entry(Goal(self.name, patience, time.monotonic()), message, operation, on_feedback)
        entry.on_accepted, entry.guard = on_accepted, guard
        posted = self._bus.post(lambda: self._submit(entry))
        posted.add_done_callback(lambda: pass_error(posted, operation))
        return operation

    # --- on the bus's thread ---

    def poll(self) -> bool:
        """Look at the goals under way; False when there are none."""
        now = time.monotonic()
        if any(e.machine.phase is not Phase.WAITING for e in self._entries):
            present = self._check.present()
            for entry in list(self._entries):
                if entry.servers:
                    self._do(entry, entry.machine.server_seen(bool(entry.servers & present), now))
                if entry.status:
                    self._do(entry, entry.machine.status(entry.status, now))
        self._advance(now)
        for entry in list(self._entries):
            self._do(entry, entry.machine.tick(now))
        return bool(self._entries)

    def end(self, error: Exception) -> None:
        """Tell every owner that the connection is being closed, and servers that their goals are canceled."""
        for entry in list(self._entries):
            self._do(entry, entry.machine.close(time.monotonic()))

    def _submit(self, entry: _Entry) -> None:
        if self._bus.closed:
            entry.operation.fail(CanceledError("the connection to ROS was closed"))
        elif self._server_ended is not None:
            entry.operation.fail(ServerLostError(f"{self.name}: {self._server_ended}", server=self.name))
        else:
            self._entries.append(entry)
            self._bus.watch()
            self._advance(time.monotonic())

    def _advance(self, now: float) -> None:
        """Send what can be sent."""
        waiting = [e for e in self._entries if e.machine.phase is Phase.WAITING]
        if not waiting:
            return
        try:
            ready = self._check.fits(now)
        except UnfitServerError as error:
            stale_possible = self._check.several()
            for entry in waiting:
                if not stale_possible or now > entry.began + min(entry.machine.patience.server, STALE):
                    self._do(entry, entry.machine.server_unfit(error))
            return
        if ready:
            for entry in waiting:
                if entry.message is None:
                    self._drop(entry)
                    entry.operation.succeed(None)
                elif sum(e.machine.phase is Phase.SENT for e in self._entries) < IN_FLIGHT:
                    self._do(entry, entry.machine.server_fits(now))

    def _connected(self) -> bool:
        if self._wire is None:
            self._wire = ActionWire(self._bus.node, self.type, self.name, self._progressed, self._statuses)
        return self._wire.server_is_ready()

    def _do(self, entry: _Entry, commands: list[Command]) -> None:
        """Carry out what the machine of a goal says; forget the goal when it is over."""
        for command in commands:
            match command:
                case Send():
                    self._send(entry)
                case AskResult():
                    if entry.result is not None:
                        entry.result.cancel()  # that request, or its answer, was dropped on the way
                    entry.result = self._connection.ask_result(entry.goal_id)
                    self._later(entry, entry.result, self._resulted)
                case AskCancel():
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
        if entry in self._entries:
            self._entries.remove(entry)
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

    def _send(self, entry: _Entry) -> None:
        entry.servers, entry.goal_id = self._check.servers, new_goal_id()
        if entry.guard is not None:
            entry.guard.sent(self.name, entry.goal_id)
        try:
            future = self._connection.send_goal(entry.goal_id, entry.message)
        except Exception as error:  # noqa: BLE001 - rclpy's own errors and TypeErrors of a wrong goal
            self._do(entry, entry.machine.send_failed(error))
            return
        self._later(entry, future, self._goal_answered)

    def _later(self, entry: _Entry, future: Any, then: Callable[[_Entry, Any], None]) -> None:
        """Call `then` with the future's result; futures that are given up are cancelled, and say nothing."""
        entry.futures.append(future)

        def ended(_: Any) -> None:
            if future in entry.futures:
                entry.futures.remove(future)
            if future.cancelled():
                return
            error = future.exception()
            if error is not None:
                self._do(entry, entry.machine.server_ended(f"the client broke: {error}"))
            else:
                then(entry, future.result())

        when_done(future, ended)

    def _goal_answered(self, entry: _Entry, response: Any) -> None:
        now = time.monotonic()
        if response.accepted and entry.on_accepted is not None:
            entry.on_accepted()
        self._do(entry, entry.machine.accepted(now) if response.accepted else entry.machine.rejected())
        self._advance(now)

    def _resulted(self, entry: _Entry, response: Any) -> None:
        self._do(entry, entry.machine.result(response.status, response.result))
        if not self._entries:  # with more under way, their answers come first
            give_way()

    def _cancel_answered(self, entry: _Entry, response: Any) -> None:
        # Its return code is 0 also for a goal that the server refused to cancel; the list is what counts. "Terminated"
        # is said of goals that end already, too.
        codes = CancelGoal.Response
        stops = bool(response.goals_canceling) or response.return_code == codes.ERROR_GOAL_TERMINATED
        known = response.return_code != codes.ERROR_UNKNOWN_GOAL_ID
        now = time.monotonic()
        self._do(entry, entry.machine.cancel_answered(stops, known, now))
        self._advance(now)

    def _progressed(self, goal_id: bytes, feedback: Any) -> None:
        entry = next((e for e in self._entries if e.goal_id == goal_id), None)
        if entry is not None and entry.machine.phase in LIVE:
            entry.operation.report(feedback)
            if entry.on_feedback is not None:
                entry.on_feedback(feedback)

    def _statuses(self, listed: bytes) -> None:
        """Hear of goals from the server, also of such whose acceptance was lost."""
        for entry in [e for e in self._entries if e.goal_id]:
            status = status_in(listed, entry.goal_id)
            if status:
                entry.status = status
                if entry.machine.phase in (Phase.SENT, Phase.LOOSE_SENT):
                    self._do(entry, entry.machine.status(status, time.monotonic()))
