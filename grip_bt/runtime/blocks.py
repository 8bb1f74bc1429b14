"""Columns of events as bytes: little-endian numbers, compressed where that is worth it."""

from __future__ import annotations

import zlib

import numpy as np
from numpy.typing import NDArray

SMALLEST = 256
"""Columns of fewer bytes aren't compressed."""

_RAW, _DEFLATED = b"r", b"z"


def pack_numbers(ids: NDArray[np.int64]) -> bytes:
    """Return whole numbers >= 0 in the fewest of 1, 2 or 4 bytes that hold them all; the first byte says which."""
    largest = int(ids.max(initial=0))
    width = 1 if largest < 2**8 else 2 if largest < 2**16 else 4
    return bytes([width]) + _squeezed(ids.astype(f"<u{width}").tobytes())


def unpack_numbers(packed: bytes, count: int) -> NDArray[np.int64]:
    """Undo `pack_numbers`.

    Raises:
        ValueError: these aren't `count` numbers.
    """
    width = packed[0]
    if width not in (1, 2, 4):
        raise ValueError(f"numbers of {width} bytes")
    return np.frombuffer(_expanded(packed[1:], width * count), f"<u{width}").astype(np.int64)


def pack_times(times: NDArray[np.float64]) -> bytes:
    """Return times [s], exactly; first all lowest bytes, ... last all highest, which hardly differ."""
    planes = times.astype("<f8").view(np.uint8).reshape(-1, 8).T
    return _squeezed(planes.tobytes())


def unpack_times(packed: bytes, count: int) -> NDArray[np.float64]:
    """Undo `pack_times`.

    Raises:
        ValueError: these aren't `count` times.
    """
    planes = np.frombuffer(_expanded(packed, 8 * count), np.uint8).reshape(8, -1)
    return np.ascontiguousarray(planes.T).view("<f8").reshape(-1)


def _squeezed(content: bytes) -> bytes:
    if len(content) >= SMALLEST:
        smaller = zlib.compress(content, 1)
        if len(smaller) < len(content):
            return _DEFLATED + smaller
    return _RAW + content


def _expanded(packed: bytes, size: int) -> bytes:
    content = expanded(packed[1:], size) if packed[:1] == _DEFLATED else packed[1:]
    if len(content) != size:
        raise ValueError(f"{len(content)} bytes in place of {size}")
    return content


def expanded(deflated: bytes, size: int) -> bytes:
    """Return what was deflated, and no more of it than one byte over `size`.

    Raises:
        zlib.error: it wasn't.
    """
    return zlib.decompressobj().decompress(deflated, size + 1)
