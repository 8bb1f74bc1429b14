"""The simulator's process, the messages to and from it, and how its answers end operations.

Nothing is pickled, so nothing that is received can run.
"""

from __future__ import annotations

import logging
import socket
import struct
import subprocess
import threading
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from grip_bt.base.errors import GripError
from grip_bt.base.failures import CanceledError, ExecutionAbortedError, ExpectedError
from grip_bt.base.interpreter import python_command
from grip_bt.base.operation import Operation
from grip_bt.base.value_codec import decode, encode

LARGEST = 64 << 20
"""Largest message [bytes]."""
_LENGTH = struct.Struct("!I")


class ClosedError(Exception):
    """The other end is gone, or says what nobody understands."""


def pack(message: Mapping[str, object]) -> bytes:
    """Return one message, as `grip_bt.base.value_codec` writes it; ValueError where it is too large."""
    content = encode(dict(message))
    if len(content) > LARGEST:
        raise ValueError(f"a message of {len(content)} bytes; at most {LARGEST} can be sent")
    return _LENGTH.pack(len(content)) + content


def receive(connection: socket.socket) -> dict[str, Any]:
    """Wait for a message; return what it says, arrays read-only. Raises ClosedError where the other end is gone."""
    (length,) = _LENGTH.unpack(_exactly(connection, _LENGTH.size))
    if length > LARGEST:
        raise ClosedError(f"a message of {length} bytes")
    try:
        return dict(decode(_exactly(connection, length)))
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError, GripError) as error:
        raise ClosedError(f"a message that can't be read: {error}") from None


def _exactly(connection: socket.socket, count: int) -> bytes:
    parts = []
    while count:
        try:
            part = connection.recv(min(count, 1 << 20))
        except OSError as error:
            raise ClosedError(str(error)) from None
        if not part:
            raise ClosedError("end of stream")
        parts.append(part)
        count -= len(part)
    return b"".join(parts)


_ERRORS: dict[str, type[ExpectedError]] = {"aborted": ExecutionAbortedError, "canceled": CanceledError}
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Reply:
    """An answer of the simulator: what it says, and when it arrived on the run's clock [s]."""

    fields: Mapping[str, Any]
    time: float


def complete(operation: Operation[Reply], reply: Reply) -> None:
    """End an operation as the simulator says: with the reply, or with the error that the reply holds."""
    error, message = reply.fields.get("error", ""), reply.fields.get("message", "")
    if error in _ERRORS:
        end(operation, _ERRORS[error](message, **reply.fields.get("data", {})))
    else:
        end(operation, GripError(message) if error else reply)


def end(operation: Operation[Reply], outcome: Reply | GripError) -> None:
    """End an operation; a callback that raises is logged, since it mustn't keep other operations from ending."""
    try:
        operation.succeed(outcome) if isinstance(outcome, Reply) else operation.fail(outcome)
    except Exception:  # noqa: BLE001
        _log.exception("a callback of a simulator's operation failed")


LINES = 40
"""How many of the last lines are kept for the message about its end."""


class SimProcess:
    """A child process that runs `python -m grip_sim.server` with its end of a socket pair, which may be closed then.

    It ends by itself when the other end is gone, also when our process was killed.
    """

    def __init__(self, connection: socket.socket, hold: int | None = None):
        descriptors = [connection.fileno(), *([] if hold is None else [hold])]
        command = python_command("-m", "grip_sim.server", *map(str, descriptors))
        # What it prints is kept from our standard output, which may carry a protocol.
        self._process = subprocess.Popen(
            command,
            pass_fds=descriptors,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
        self._said: deque[bytes] = deque(maxlen=LINES)
        self._listener = threading.Thread(target=self._listen, name="grip_sim_output", daemon=True)
        self._listener.start()

    @property
    def pid(self) -> int:
        """The process id."""
        return self._process.pid

    def end(self, patience: float) -> int:
        """Wait for its end, kill it after `patience` [s], and return its exit status."""
        try:
            return self._process.wait(patience)
        except subprocess.TimeoutExpired:
            self._process.kill()
            return self._process.wait()

    def last_words(self) -> str:
        """Return what it printed last, at most 2000 characters."""
        self._listener.join(1.0)  # after its end this takes no time
        return b"".join(self._said).decode(errors="replace").strip()[-2000:]

    def close(self) -> None:
        """Give back the pipe; after the end."""
        self._listener.join(1.0)
        if not self._listener.is_alive() and self._process.stdout is not None:
            self._process.stdout.close()

    def _listen(self) -> None:
        assert self._process.stdout is not None
        self._said.extend(self._process.stdout)
