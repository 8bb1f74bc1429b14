"""The simulator's process seen from ours: starts it, sends requests, completes operations, notices its end.

Importing this module loads no sapien.
"""

from __future__ import annotations

import queue
import socket
import subprocess
import sys
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from grip_bt.errors import CanceledError, ExecutionAbortedError, ExpectedError, GripError, SimulatorLostError
from grip_bt.operation import Operation

from .clock import SimClock
from .specs import WorldSpec
from .wire import Arrays, ClosedError, pack, receive

START_TIME, ANSWER_TIME, CLOSE_TIME = 60.0, 30.0, 1.0
_ERRORS: dict[str, type[ExpectedError]] = {"aborted": ExecutionAbortedError, "canceled": CanceledError}


@dataclass(frozen=True)
class Reply:
    """An answer of the simulator: its fields and arrays."""

    fields: Mapping[str, Any]
    arrays: Mapping[str, NDArray[Any]]


class SimClient:
    """Owns one simulator process.

    Args:
        spec: the world to make.
        pace: simulated seconds per second; None for as fast as it goes.

    Raises:
        SimulatorLostError: it didn't start; the message holds what it printed.
    """

    def __init__(self, spec: WorldSpec, pace: float | None = None):
        self.clock = SimClock()
        self._lock = threading.Lock()
        self._pending: dict[int, tuple[Operation[Reply], bool]] = {}
        self._completions: queue.SimpleQueue[tuple[Operation[Reply], Reply] | None] = queue.SimpleQueue()
        self._count = 0
        self._lost: SimulatorLostError | None = None
        ours, theirs = socket.socketpair()
        self._connection = ours
        command = [sys.executable, "-m", "grip_sim", str(theirs.fileno())]
        self._process = subprocess.Popen(
            command, pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL, stderr=subprocess.PIPE
        )
        theirs.close()
        self._said: list[bytes] = []
        self._listener = threading.Thread(target=self._listen, name="grip_sim_stderr", daemon=True)
        self._listener.start()
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

    def ask(self, call: str, /, **fields: Any) -> Reply:
        """Call and wait for the answer, which comes within milliseconds.

        Raises:
            SimulatorLostError: the process has ended or doesn't answer.
            GripError: the simulator refused.
        """
        return self._await(self._send({"call": call, **fields}, waited_for=True), ANSWER_TIME)

    def request(self, call: str, /, **fields: Any) -> Operation[Reply]:
        """Call something that advances no physics, without waiting."""
        return self._send({"call": call, **fields})

    def move(self, call: str, /, arrays: Arrays | None = None, **fields: Any) -> Operation[Reply]:
        """Begin something that advances the physics; cancelling it stops that motion."""
        self.clock.begin()
        operation = self._send({"call": call, **fields}, arrays, cancelable=True)
        operation.add_done_callback(self.clock.end)
        return operation

    def close(self) -> None:
        """End the process; pending operations fail. Harmless when it was closed before."""
        self._fail_all(SimulatorLostError("the simulation was closed"))
        try:
            self._connection.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # the other end went first
        try:
            self._process.wait(CLOSE_TIME)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        for thread in (self._reader, self._completer, self._listener):
            if thread is not threading.current_thread():
                thread.join()
        self._connection.close()
        if self._process.stderr is not None:
            self._process.stderr.close()

    # --- requests ---

    def _send(
        self,
        fields: dict[str, Any],
        arrays: Arrays | None = None,
        cancelable: bool = False,
        waited_for: bool = False,
    ) -> Operation[Reply]:
        with self._lock:
            if self._lost is not None:
                return Operation.failed(self._lost)
            self._count += 1
            number = self._count
            cancel = (lambda: self._cancel(number)) if cancelable else None
            operation: Operation[Reply] = Operation(cancel)
            self._pending[number] = (operation, waited_for)
            message = pack({"id": number, **fields}, arrays)
            try:
                self._connection.sendall(message)
            except OSError:
                pass  # the reader notices the end and fails every pending operation
        return operation

    def _cancel(self, number: int) -> None:
        self._send({"call": "cancel", "motion": number})

    def _await(self, operation: Operation[Reply], seconds: float) -> Reply:
        if not operation.wait(seconds):
            raise SimulatorLostError(f"the simulator (process {self.pid}) gives no answer within {seconds:.0f} s")
        return operation.result()

    # --- answers ---

    def _read(self) -> None:
        try:
            while True:
                fields, arrays = receive(self._connection)
                self.clock.told(fields["time"])
                with self._lock:
                    operation, waited_for = self._pending.pop(fields["id"], (None, False))
                if operation is None:
                    continue
                # Callbacks may ask for more and wait for it, so they aren't called in the thread that reads answers.
                if waited_for:
                    _complete(operation, Reply(fields, arrays))
                else:
                    self._completions.put((operation, Reply(fields, arrays)))
        except ClosedError:
            self._process.wait()
            self._listener.join(1.0)
            said = b"".join(self._said).decode(errors="replace").strip()[-2000:]
            status = self._process.returncode
            self._fail_all(SimulatorLostError(f"the simulator's process ended with status {status}. {said}".strip()))

    def _complete_all(self) -> None:
        while (completion := self._completions.get()) is not None:
            _complete(*completion)

    def _fail_all(self, error: SimulatorLostError) -> None:
        with self._lock:
            self._lost = self._lost or error
            pending, self._pending = list(self._pending.values()), {}
        self._completions.put(None)
        for operation, _ in pending:
            operation.fail(self._lost)

    def _listen(self) -> None:
        assert self._process.stderr is not None
        for line in self._process.stderr:
            self._said = [*self._said[-40:], line]


def _complete(operation: Operation[Reply], reply: Reply) -> None:
    error, message = reply.fields.get("error", ""), reply.fields.get("message", "")
    if not error:
        operation.succeed(reply)
    elif error in _ERRORS:
        operation.fail(_ERRORS[error](message))
    else:
        operation.fail(GripError(message))
