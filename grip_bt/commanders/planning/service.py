"""Planning in a process of its own: OMPL holds Python's lock, and a plan must not stop a task from ticking.

The process is `python -m` of this module. It reads messages from stdin and writes messages to a private copy of stdout,
each a pickled tuple; both ends are one program on one machine, so pickle is safe here. The end of stdin means that the
parent is gone, however it went.
"""

from __future__ import annotations

import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from itertools import count
from typing import IO, Literal

from grip_bt.base.failures import CanceledError, PlannerLostError
from grip_bt.base.files import Closing
from grip_bt.base.interpreter import how_ended, python_command
from grip_bt.base.operation import Operation
from grip_bt.base.values import Plan

from ..description.robot import RobotDescription
from .requests import ChosenGrasp, Request

PROGRAM = "grip_bt.commanders.planning.service"
CANCEL_GRACE = 0.04
"""A cancelled request has this long [s] to end by itself; then the process is replaced."""

Message = (
    tuple[Literal["robot"], RobotDescription]
    | tuple[Literal["plan"], int, Request]
    | tuple[Literal["cancel"], int]
    | tuple[Literal["ready"]]
    | tuple[Literal["done"], int, Plan | ChosenGrasp | None]
    | tuple[Literal["failed"], int, Exception]
)
"""In: the robot once, then plans and cancellations. Out: `ready` once, then answers."""


def _write(stream: IO[bytes], message: Message) -> None:
    """Write one message; nothing of one that can't be pickled."""
    stream.write(pickle.dumps(message, protocol=pickle.HIGHEST_PROTOCOL))
    stream.flush()


def _read(stream: IO[bytes]) -> Message | None:
    """Return the next message, or None at the end of the stream, in the middle of one too."""
    try:
        return pickle.load(stream)
    except (EOFError, pickle.UnpicklingError):
        return None


@dataclass
class _Job:
    number: int
    request: Request
    operation: Operation[Plan | ChosenGrasp | None]
    sent_again: bool = False


class PlanningProcess(Closing):
    """Sends requests to a child process, one after the other.

    The child is started at once and replaced when it dies; the request that it died over is sent once more. It ends
    when this process ends, however that ends, since its stdin does.

    Attributes:
        told: called with words when a child has died and another one takes its place; on a thread of our own.
    """

    def __init__(self, robot: RobotDescription, told: Callable[[str], None] = lambda words: None):
        self._robot, self.told = robot, told
        self._given_up: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()
        self._jobs: dict[int, _Job] = {}
        self._numbers = count(1)
        self._closed = False
        self._ready = threading.Event()
        self._settled = threading.Event()
        self._stillborn = 0
        self._spawn()

    @property
    def pid(self) -> int:
        """The process id of the present child."""
        return self._child.pid

    def wait_until_ready(self, timeout: float = 300.0) -> bool:
        """Block until the child has built its model, at most `timeout` [s]; requests may be sent before.

        Returns:
            False when it hasn't, or can't start at all.
        """
        self._settled.wait(timeout)
        return self._ready.is_set()

    def submit(self, request: Request) -> Operation[Plan | ChosenGrasp | None]:
        with self._lock:
            if self._closed:
                raise RuntimeError("the planning process was closed")
            number = next(self._numbers)
            operation: Operation[Plan | ChosenGrasp | None] = Operation(on_cancel=lambda: self._cancel(number))
            if self._stillborn >= 2:
                return Operation.failed(_lost(self._child))
            self._jobs[number] = _Job(number, request, operation)
            self._send(("plan", number, request))
        return operation

    def close(self) -> None:
        """End the child; requests under way end as cancelled. Harmless when called again."""
        with self._lock:
            self._closed = True
            child, jobs = self._child, list(self._jobs.values())
            self._jobs.clear()
        child.kill()
        if threading.current_thread() is not self._reader:
            self._reader.join()
        for job in jobs:
            job.operation.fail(CanceledError("the planning process was closed"))

    def _spawn(self) -> None:
        """Start a child. The lock is held, or nobody else knows this object yet."""
        self._ready.clear()
        self._settled.clear()
        self._child = child = subprocess.Popen(
            python_command("-m", PROGRAM),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            # Threads that wait by spinning would take a core from the simulator.
            env={**os.environ, "OMP_WAIT_POLICY": "PASSIVE"},
        )
        self._send(("robot", self._robot))
        self._reader = threading.Thread(target=self._read, args=(child,), name="planner", daemon=True)
        self._reader.start()

    def _send(self, message: Message) -> None:
        """Send to the present child; when it is dead, its reader finds out and sends again."""
        assert self._child.stdin is not None
        try:
            _write(self._child.stdin, message)
        except (BrokenPipeError, ValueError):
            return

    def _read(self, child: subprocess.Popen[bytes]) -> None:
        assert child.stdout is not None
        while (message := _read(child.stdout)) is not None:
            match message:
                case ("ready",):
                    self._ready.set()
                    self._settled.set()
                case ("done", number, result) if (job := self._ended(number)) is not None:
                    job.operation.succeed(result)
                case ("failed", number, error) if (job := self._ended(number)) is not None:
                    job.operation.fail(error)
        child.wait()
        child.stdout.close()
        self._replace(child)
        if child.stdin is not None:
            with suppress(BrokenPipeError):  # what it still holds can't be delivered
                child.stdin.close()

    def _ended(self, number: int) -> _Job | None:
        with self._lock:
            return self._jobs.pop(number, None)

    def _replace(self, dead: subprocess.Popen[bytes]) -> None:
        """Start another child in place of a dead one and send it what is still wanted."""
        with self._lock:
            if self._closed or dead is not self._child:
                return
            self._stillborn = 0 if self._ready.is_set() else self._stillborn + 1
            lost = self._lost_jobs()
            if self._stillborn < 2:
                self._spawn()
                for job in self._jobs.values():
                    self._send(("plan", job.number, job.request))
            wanted, other = len(self._jobs), self._child.pid
        for job in lost:
            job.operation.fail(_lost(dead))
        if dead is not self._given_up and other != dead.pid:
            again = ", and repeats the request" if wanted else ""
            self.told(f"process {dead.pid} {how_ended(dead.returncode)}; process {other} replaces it{again}")

    def _lost_jobs(self) -> list[_Job]:
        """Take out the jobs that won't be sent again: the one that two children died over, or all if none can start."""
        if self._stillborn >= 2:
            self._settled.set()
            lost = list(self._jobs.values())
        else:
            oldest = min(self._jobs.values(), key=lambda job: job.number, default=None)
            lost = [oldest] if oldest is not None and oldest.sent_again else []
            if oldest is not None:
                oldest.sent_again = True
        for job in lost:
            del self._jobs[job.number]
        return lost

    def _cancel(self, number: int) -> None:
        with self._lock:
            if number not in self._jobs:
                return
            self._send(("cancel", number))
        timer = threading.Timer(CANCEL_GRACE, self._give_up, args=(number,))
        timer.daemon = True
        timer.start()

    def _give_up(self, number: int) -> None:
        """End a cancelled request whose work doesn't end; its process is replaced."""
        with self._lock:
            job = self._jobs.pop(number, None)
            running = job is not None and all(other > number for other in self._jobs)
            child = self._child
        if job is None:
            return
        if running and self._ready.is_set():
            self._given_up = child
            child.kill()
        job.operation.fail(CanceledError("planning was cancelled"))


def _lost(dead: subprocess.Popen[bytes]) -> PlannerLostError:
    how = how_ended(dead.returncode)
    words = f"the planning process died twice: process {dead.pid} {how}; what it printed on stderr may tell why"
    return PlannerLostError(words, exit_status=dead.returncode)


def main() -> None:
    """Serve until stdin ends."""
    for each in (signal.SIGINT, signal.SIGHUP):
        signal.signal(each, signal.SIG_IGN)  # Ctrl-C and a dropped terminal are the parent's business; it closes stdin
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print must not get between the messages
    requests: queue.SimpleQueue[Message] = queue.SimpleQueue()
    canceled = set[int]()

    def read() -> None:  # on a thread of its own, so that a cancellation is seen while a plan is being made
        while (message := _read(sys.stdin.buffer)) is not None:
            match message:
                case ("cancel", number):
                    canceled.add(number)
                case _:
                    requests.put(message)
        os._exit(0)  # whatever OMPL is doing: nobody waits for it any more

    threading.Thread(target=read, name="inbox", daemon=True).start()

    from ..kinematics.model import RobotModel
    from .answer import answer

    model: RobotModel | None = None
    while True:
        match requests.get():
            case ("robot", description):
                model = RobotModel(description)
                _write(out, ("ready",))
            case ("plan", number, request) if model is not None:
                try:
                    result = answer(model, request, lambda number=number: number in canceled)  # type: ignore[misc]
                except Exception as error:  # noqa: BLE001 - sent to the caller, who raises it
                    _write(out, ("failed", number, _sendable(error)))
                else:
                    _write(out, ("done", number, result))


def _sendable(error: Exception) -> Exception:
    """Return the error, or a plain copy of its words where it can't be pickled."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:  # noqa: BLE001 - any error of anybody's __reduce__
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error


if __name__ == "__main__":
    main()
