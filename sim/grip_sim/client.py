"""A connection to a simulator: sends requests, completes operations, keeps the run's clock, notices its loss.

Importing this module loads no sapien.
"""

from __future__ import annotations

import itertools
import queue
import select
import socket
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

from grip_bt.base.errors import SimulatorLostError
from grip_bt.base.files import Closing
from grip_bt.base.operation import Operation
from grip_bt.base.ports import InTurnOf
from grip_sim.connection import ClosedError, Reply, SimProcess, complete, end, pack, receive
from grip_sim.specs import WorldSpec


class SimClock:
    """Simulated time while something moves, our own time while nothing does; it never decreases but once.

    Physics stands still between motions, and whoever moves the robot by hand has time-outs all the same. A run that
    takes turns with the simulator has simulated time alone: nothing in it depends on how long anything takes us.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._simulated = 0.0
        self._idle = 0.0
        self._idle_since: float | None = time.monotonic()
        self._moving = 0
        self._latest = 0.0
        self._paused = self._simulated_only = False

    def now(self) -> float:
        """Return the time [s]."""
        with self._lock:
            idle = 0.0 if self._idle_since is None else time.monotonic() - self._idle_since
            # the same sum, rounded in another order, may be smaller in its last bit
            self._latest = max(self._latest, self._simulated + self._idle + idle)
            return self._latest

    @property
    def simulated(self) -> float:
        """Simulated time alone [s]."""
        return self._simulated

    def count(self, more: int) -> None:
        """Take note of a motion that begins (1), or has ended (-1)."""
        with self._lock:
            self._moving += more
            self._let_idle()

    def hold(self, paused: bool) -> None:
        """Stand still also while nothing moves, or go on; harmless when it does already."""
        with self._lock:
            self._paused = paused
            self._let_idle()

    def keep_to_simulated(self, only: bool) -> None:
        """Show simulated time alone, from which our own is taken out again; or let our own go on."""
        with self._lock:
            self._simulated_only = only
            self._let_idle()
            if only:
                self._idle, self._latest = 0.0, self._simulated

    def _let_idle(self) -> None:
        """Have our own time go on where nothing stops it any more, and stop where something does."""
        idles = self._moving == 0 and not self._paused and not self._simulated_only
        if self._idle_since is not None:
            self._idle += time.monotonic() - self._idle_since
        self._idle_since = time.monotonic() if idles else None

    def told(self, simulated: float) -> None:
        """Take over the simulator's time [s]."""
        with self._lock:
            self._simulated = max(self._simulated, simulated)


START_TIME, ANSWER_TIME, CLOSE_TIME = 300.0, 120.0, 1.0
SILENCE = 120.0
"""A simulator that owes an answer and says nothing for this long is lost [s]; while it moves it tells its time."""


QUESTIONS = frozenset({"state", "feel", "kept", "truth", "measures", "fingerprint", "camera_pose", "passed"})
"""Calls that change nothing: while the world stands still, each is answered once."""


def _unheard(name: str, words: str, over: bool) -> None: ...


class SimClient(Closing):
    """Owns one simulator process.

    Attributes:
        sent: how many requests were sent that may change something, without what is said of turns.
        on_fault: told of each fault of the world that begins or is over: its name, what happened, whether it is over.

    Args and what is raised: see `start_simulation`.
    """

    def __init__(self, spec: WorldSpec, pace: float | None = None, hold: int | None = None):
        self.clock = SimClock()
        self._lock = threading.Lock()  # over what is pending and lost, and the order of completions
        self._sending = threading.Lock()  # apart: a full pipe must not keep the reader from emptying the other one
        self._pending: dict[int, tuple[Operation[Reply], bool]] = {}
        self._completions: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self.sent, self._numbers = 0, itertools.count(1)
        self._stands, self._answers = False, dict[str, Reply]()  # of questions, since something may have changed
        self.on_fault: Callable[[str, str, bool], None] = _unheard
        self._in_turn: InTurnOf | None = None
        self._stood: Callable[[], None] = lambda: None
        self._lost: SimulatorLostError | None = None
        self._connection, theirs = socket.socketpair()
        with theirs:
            self._process = SimProcess(theirs, hold)
        self._reader = threading.Thread(target=self._read, name="grip_sim", daemon=True)
        self._completer = threading.Thread(target=self._complete_all, name="grip_sim_done", daemon=True)
        self._reader.start()
        self._completer.start()
        try:
            self._await(self._send({"spec": spec.to_json(), "pace": pace}, waited_for=True), START_TIME)
        except BaseException:
            self.close()
            raise

    @property
    def pid(self) -> int:
        """The process id."""
        return self._process.pid

    def ask(self, call: str, /, **fields: object) -> Reply:
        """Call and wait for the answer, which comes within milliseconds.

        Raises:
            SimulatorLostError: the process has ended or doesn't answer.
            GripError: the simulator refused.
        """
        answers, question = self._answers, f"{call} {fields}"
        if call in QUESTIONS and question in answers:
            return answers[question]
        reply = self._await(self._send({"call": call, **fields}, waited_for=True), ANSWER_TIME)
        if call in QUESTIONS and self._stands:
            answers[question] = reply  # forgotten by now, where something was sent, or time has passed, meanwhile
        return reply

    def request(self, call: str, /, **fields: object) -> Operation[Reply]:
        """Call something that advances no physics, without waiting."""
        operation = self._send({"call": call, **fields})
        return operation if self._in_turn is None else self._in_turn(operation, holds=True)

    def move(self, call: str, /, **fields: object) -> Operation[Reply]:
        """Begin something that advances the physics; cancelling it stops that motion."""
        self.clock.count(1)
        try:
            operation = self._send({"call": call, **fields}, cancelable=True)
        except BaseException:
            self.clock.count(-1)
            raise
        operation.add_done_callback(partial(self.clock.count, -1))
        return operation if self._in_turn is None else self._in_turn(operation, holds=False)

    def begin(self, spec: WorldSpec) -> None:
        """Have another world in place of this one, as a new process would; nothing of the old one stays.

        Raises:
            SimulatorLostError, GripError: see `ask`.
        """
        self.on_fault, self._in_turn, self._stood, self._stands = _unheard, None, lambda: None, False
        self._await(self._send({"call": "begin", "spec": spec.to_json()}, waited_for=True), START_TIME)
        self.clock = SimClock()  # after the answer, so that nothing tells it a time of the old world

    def lives(self) -> bool:
        """Tell whether it can be asked for anything."""
        return self._lost is None

    def take_turns(self, in_turn: InTurnOf, stood: Callable[[], None]) -> None:
        """Have simulated time stand still but for `go`; see `grip_bt.base.ports.Stepped`."""
        self.ask("take_turns")
        self._in_turn, self._stood, self._stands = in_turn, stood, True

    def go(self, until: float | None) -> bool:
        """Have simulated time go on; False when the simulator is lost."""
        self._stands = False
        there = not self._tell("go", until=until)
        self._answers = {}
        return there

    def stand(self) -> None:
        """Have it stand still now."""
        self._tell("stand")

    def go_freely(self) -> None:
        """Have it go by itself again."""
        self._in_turn, self._stands, self._answers = None, False, {}
        self._tell("go_freely")

    def _tell(self, call: str, **fields: object) -> bool:
        """Say something about turns, to which there is no answer; return whether nobody is there any more."""
        with suppress(OSError):  # the reader notices the end
            with self._sending:
                self._connection.sendall(pack({"id": 0, "call": call, **fields}))
        return self._lost is not None

    def close(self) -> None:
        """End the process; pending operations fail. Harmless when it was closed before."""
        self._lose(SimulatorLostError("the simulation was closed"))
        self._hang_up()
        self._process.end(CLOSE_TIME)
        for thread in (self._reader, self._completer):
            if thread is not threading.current_thread():
                thread.join(CLOSE_TIME)  # not for ever: a callback may wait for whoever closes
        self._connection.close()
        self._process.close()

    def _send(
        self,
        fields: dict[str, object],
        cancelable: bool = False,
        waited_for: bool = False,
    ) -> Operation[Reply]:
        number, changes = next(self._numbers), fields.get("call") not in QUESTIONS
        message = pack({"id": number, **fields})

        def cancel() -> None:
            self._send({"call": "cancel", "motion": number})

        operation: Operation[Reply] = Operation(cancel if cancelable else None)
        with self._lock:
            if self._lost is not None:
                return Operation.failed(self._lost)
            self._pending[number] = (operation, waited_for)
            self.sent += changes
        with suppress(OSError):  # the reader notices the end and fails every pending operation
            with self._sending:
                self._connection.sendall(message)
        if changes:
            self._answers = {}
        return operation

    def _await(self, operation: Operation[Reply], seconds: float) -> Reply:
        if not operation.wait_here(seconds):
            raise SimulatorLostError(f"the simulator (process {self.pid}) gives no answer within {seconds:.0f} s")
        return operation.result()

    def _read(self) -> None:
        try:
            while True:
                owed = next(iter(tuple(self._pending)), None)  # what is asked for meanwhile isn't late
                if select.select([self._connection], [], [], SILENCE)[0]:
                    self._answered(receive(self._connection))
                elif owed in self._pending:
                    raise ClosedError(f"it said nothing for {SILENCE:.0f} s")
        except ClosedError as reason:
            self._hang_up()
            status = self._process.end(CLOSE_TIME)
            said = self._process.last_words()
            message = f"the simulator's process {self.pid} is gone ({reason}; exit status {status}). {said}"
            self._lose(SimulatorLostError(message.strip()))

    def _answered(self, fields: dict[str, Any]) -> None:
        self.clock.told(fields["time"])
        reply = Reply(fields, self.clock.now())
        with self._lock:
            operation, waited_for = self._pending.pop(fields["id"], (None, False))
            if operation is not None and not waited_for:
                # Callbacks may ask for more and wait for it, so they aren't called in the thread that reads answers.
                # Under the lock: once nothing is pending and all is lost, the last completion is in the queue.
                self._completions.put(partial(complete, operation, reply))
                return
            if "fault" in fields:
                self._completions.put(partial(self.on_fault, *fields["fault"]))
            if fields.get("stands"):  # behind the ends that came before
                self._stands, self._answers = self._in_turn is not None, {}
                self._completions.put(self._stood)
        if operation is not None:
            complete(operation, reply)

    def _complete_all(self) -> None:
        while (completion := self._completions.get()) is not None:
            completion()

    def _lose(self, error: SimulatorLostError) -> None:
        with self._lock:
            if self._lost is not None:
                return
            self._lost = error
            pending, self._pending = list(self._pending.values()), {}
            self._completions.put(None)
        for operation, _ in pending:
            end(operation, error)
        self._stood()

    def _hang_up(self) -> None:
        with suppress(OSError):  # the other end went first
            self._connection.shutdown(socket.SHUT_RDWR)
