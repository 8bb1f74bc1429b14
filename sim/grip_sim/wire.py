"""Messages between the simulator's process and ours: a JSON header and raw arrays, each with its length first.

Nothing is pickled, so nothing that is received can run.
"""

from __future__ import annotations

import json
import socket
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Arrays = Mapping[str, NDArray[Any]]
_LENGTH = struct.Struct("!I")
_LARGEST = 64 << 20


class ClosedError(Exception):
    """The other end is gone."""


def pack(fields: Mapping[str, Any], arrays: Arrays | None = None) -> bytes:
    """Return one message."""
    blocks = {name: np.ascontiguousarray(array) for name, array in (arrays or {}).items()}
    shapes = [[name, block.dtype.str, block.shape] for name, block in blocks.items()]
    header = json.dumps({"fields": fields, "arrays": shapes}).encode()
    body = b"".join(block.tobytes() for block in blocks.values())
    return _LENGTH.pack(len(header)) + _LENGTH.pack(len(body)) + header + body


def receive(connection: socket.socket) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Wait for one message and return its fields and arrays.

    Raises:
        ClosedError: the other end is gone.
    """
    lengths = _exactly(connection, 2 * _LENGTH.size)
    (header_length,), (body_length,) = _LENGTH.unpack(lengths[:4]), _LENGTH.unpack(lengths[4:])
    if header_length + body_length > _LARGEST:
        raise ClosedError(f"a message of {header_length + body_length} bytes")
    header = json.loads(_exactly(connection, header_length))
    body = memoryview(_exactly(connection, body_length))
    arrays, offset = {}, 0
    for name, dtype, shape in header["arrays"]:
        kind = np.dtype(dtype)
        size = kind.itemsize * int(np.prod(shape))
        arrays[name] = np.frombuffer(body[offset : offset + size], kind).reshape(shape)
        offset += size
    return header["fields"], arrays


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
