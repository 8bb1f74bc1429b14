"""The planning process: `python -m grip_bt.commanders.planning.process`, started by `planning.service`.

It reads messages from stdin and writes messages to a private copy of stdout, each a pickled tuple. Both ends are one
program on one machine, so pickle is safe here; nothing from outside gets in.

    in   ("robot", RobotDescription) once, then ("plan", number, request) and ("cancel", number)
    out  ("ready",) once, then ("done", number, result) or ("failed", number, error)

The end of stdin means that the parent is gone, however it went: the thread that reads then ends the process.
"""

from __future__ import annotations

import os
import pickle
import queue
import signal
import sys
import threading
from functools import partial
from typing import IO, Literal

from grip_bt.base.values import Plan

from ..description.robot import RobotDescription
from .requests import ChosenGrasp, Request

Message = (
    tuple[Literal["robot"], RobotDescription]
    | tuple[Literal["plan"], int, Request]
    | tuple[Literal["cancel"], int]
    | tuple[Literal["ready"]]
    | tuple[Literal["done"], int, Plan | ChosenGrasp | None]
    | tuple[Literal["failed"], int, Exception]
)


def write_message(stream: IO[bytes], message: Message) -> None:
    """Write one message; nothing of one that can't be pickled."""
    stream.write(pickle.dumps(message, protocol=pickle.HIGHEST_PROTOCOL))
    stream.flush()


def read_message(stream: IO[bytes]) -> Message | None:
    """Return the next message, or None at the end of the stream, in the middle of one too."""
    try:
        return pickle.load(stream)
    except (EOFError, pickle.UnpicklingError):
        return None


class Inbox:
    """Reads messages on a thread of its own, so that a cancellation is seen while a plan is being made."""

    def __init__(self, stream: IO[bytes]):
        self.requests: queue.SimpleQueue[Message] = queue.SimpleQueue()
        self._stream = stream
        self._canceled: set[int] = set()
        threading.Thread(target=self._read, name="inbox", daemon=True).start()

    def canceled(self, number: int) -> bool:
        """Tell whether a request was cancelled."""
        return number in self._canceled

    def _read(self) -> None:
        while (message := read_message(self._stream)) is not None:
            match message:
                case ("cancel", number):
                    self._canceled.add(number)
                case _:
                    self.requests.put(message)
        os._exit(0)  # whatever OMPL is doing: nobody waits for it any more


def main() -> None:
    """Serve until stdin ends."""
    for each in (signal.SIGINT, signal.SIGHUP):
        signal.signal(each, signal.SIG_IGN)  # Ctrl-C and a dropped terminal are the parent's business; it closes stdin
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what libraries print must not get between the messages
    inbox = Inbox(sys.stdin.buffer)

    from ..kinematics.model import RobotModel
    from .answer import answer

    model: RobotModel | None = None
    while True:
        match inbox.requests.get():
            case ("robot", description):
                model = RobotModel(description)
                write_message(out, ("ready",))
            case ("plan", number, request) if model is not None:
                try:
                    result = answer(model, request, partial(inbox.canceled, number))
                except Exception as error:  # noqa: BLE001 - sent to the caller, who raises it
                    write_message(out, ("failed", number, _sendable(error)))
                else:
                    write_message(out, ("done", number, result))


def _sendable(error: Exception) -> Exception:
    """Return the error, or a plain copy of its words where it can't be pickled."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:  # noqa: BLE001 - any error of anybody's __reduce__
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error


if __name__ == "__main__":
    main()
