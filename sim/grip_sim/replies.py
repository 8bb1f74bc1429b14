"""What the simulator answers, and how an answer ends an operation."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from grip_bt.base.errors import GripError
from grip_bt.base.failures import CanceledError, ExecutionAbortedError, ExpectedError
from grip_bt.base.operation import Operation

_ERRORS: dict[str, type[ExpectedError]] = {"aborted": ExecutionAbortedError, "canceled": CanceledError}
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Reply:
    """An answer of the simulator.

    Attributes:
        fields: JSON data.
        arrays: by name.
        time: when it arrived, on the run's clock [s].
    """

    fields: Mapping[str, Any]
    arrays: Mapping[str, NDArray[Any]]
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
