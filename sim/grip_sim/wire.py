"""Messages between the simulator's process and ours: a JSON header and raw arrays, each with its length first.

Nothing is pickled, so nothing that is received can run.
"""

from __future__ import annotations

import json
import math
import socket
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Arrays = Mapping[str, NDArray[Any]]
LARGEST = 64 << 20
"""Largest message [bytes]."""
_LENGTHS = struct.Struct("!II")
_KINDS = "biufc"


class ClosedError(Exception):
    """The other end is gone, or says what nobody understands."""


def pack(fields: Mapping[str, Any], arrays: Arrays | None = None) -> bytes:
    """Return one message.

    Raises:
        TypeError: an array doesn't hold plain numbers, or a field isn't JSON data.
        ValueError: the message is too large.
    """
    blocks = {name: np.asarray(array) for name, array in (arrays or {}).items()}
    for name, block in blocks.items():
        if block.dtype.kind not in _KINDS:
            raise TypeError(f"array {name!r} holds {block.dtype}; only plain numbers can be sent")
    shapes = [[name, block.dtype.str, block.shape] for name, block in blocks.items()]
    header = json.dumps({"fields": fields, "arrays": shapes}).encode()
    size = len(header) + sum(block.nbytes for block in blocks.values())
    if size > LARGEST:
        raise ValueError(f"a message of {size} bytes; at most {LARGEST} can be sent")
    body = b"".join(block.tobytes() for block in blocks.values())
    return _LENGTHS.pack(len(header), len(body)) + header + body


def receive(connection: socket.socket) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Wait for one message and return its fields and its arrays, which are read-only.

    Raises:
        ClosedError: the other end is gone, or what it sent is no message.
    """
    header_length, body_length = _LENGTHS.unpack(_exactly(connection, _LENGTHS.size))
    if header_length + body_length > LARGEST:
        raise ClosedError(f"a message of {header_length + body_length} bytes")
    header, body = _exactly(connection, header_length), _exactly(connection, body_length)
    try:
        content = json.loads(header)
        return dict(content["fields"]), _arrays(content["arrays"], body)
    except (ValueError, KeyError, TypeError) as error:
        raise ClosedError(f"a message that can't be read: {error!r}") from None


def _arrays(shapes: list[Any], body: bytes) -> dict[str, NDArray[Any]]:
    arrays, offset = {}, 0
    for name, dtype, shape in shapes:
        count = math.prod(shape)
        arrays[name] = np.frombuffer(body, np.dtype(dtype), count, offset).reshape(shape)
        offset += arrays[name].nbytes
    return arrays


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
