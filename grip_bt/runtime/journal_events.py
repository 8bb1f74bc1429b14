"""Events as a journal has them, in columns of bytes; and what is none, of a file that anybody may have damaged."""

from __future__ import annotations

import json
import math
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

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
    """Undo `pack_numbers`; ValueError where these aren't `count` numbers."""
    width = packed[0]
    if width not in (1, 2, 4):
        raise ValueError(f"numbers of {width} bytes")
    return np.frombuffer(_expanded(packed[1:], width * count), f"<u{width}").astype(np.int64)


def pack_times(times: NDArray[np.float64]) -> bytes:
    """Return times [s], exactly; first all lowest bytes, ... last all highest, which hardly differ."""
    planes = times.astype("<f8").view(np.uint8).reshape(-1, 8).T
    return _squeezed(planes.tobytes())


def unpack_times(packed: bytes, count: int) -> NDArray[np.float64]:
    """Undo `pack_times`; ValueError where these aren't `count` times."""
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


MOST = 65536
"""Most events in one block."""
DAMAGED = "damaged"
"""Kind of the events that stand where others can't be read; no journal has them."""
Meaning = Literal["success", "failure"]
Name = tuple[str, str, str | None, str | None]
"""Of an event: path, kind, outcome and code."""
_LONGEST = 1e10
"""No time of a journal is later [s]: some 300 years."""
_WORDS = ("variable", "type", "preview", "text", "message", "status", "state", "how", "part", "where", "traceback")
_TABLES = ("options", "restored", "anew", "forked_from", "outcomes")


@dataclass(frozen=True)
class Event:
    """One event of a run.

    Attributes:
        seq: 1, 2, 3 ... without a gap.
        t: the run's clock [s].
        wall: wall time [s since 1970].
        path: the node; `/` for the root and for the run itself.
        meaning: of an end's outcome: `success` or `failure`; None where the journal doesn't say.
    """

    seq: int
    t: float
    wall: float
    path: str
    event: str
    outcome: str | None
    code: str | None
    data: dict[str, Any]
    meaning: Meaning | None = None


def is_time(value: object) -> bool:
    """Tell whether this can be a time of a journal [s]."""
    return isinstance(value, int | float) and math.isfinite(value) and abs(value) <= _LONGEST


def is_name(path: object, kind: object, outcome: object, code: object) -> bool:
    """Tell whether this can be what an event is of."""
    plain = isinstance(path, str) and isinstance(kind, str) and bool(path) and bool(kind)
    return plain and isinstance(outcome, str | None) and isinstance(code, str | None)


def checksum(columns: tuple[object, ...]) -> int:
    """Return the CRC-32 of a block's columns, from `first` to `data`."""
    total = 0
    for column in columns:
        content = column if isinstance(column, bytes) else repr(column).encode(errors="backslashreplace")
        total = zlib.crc32(content, total)
    return total


def sound(kind: str, data: object) -> dict[str, Any]:
    """Return an event's data with fields of the types that readers rely on; ValueError where it has no such data."""
    if not isinstance(data, dict) or any(not isinstance(data.get(key, {}), dict) for key in _TABLES):
        raise ValueError(f"the data of an event ({kind}) isn't what its kind has")
    for key in _WORDS:
        if key in data and not isinstance(data[key], str):
            data[key] = str(data[key])
    if kind == "write" and "variable" not in data or kind == "kept" and "part" not in data:
        raise ValueError(f"an event ({kind}) doesn't say of what")
    return data


def unpacked(
    row: tuple[Any, ...], names: Mapping[int, Name], part: slice
) -> list[tuple[int, float, float, Name, dict[str, Any]]]:
    """Return what a block says of `part` of its events: index, time, wall time, what it is of, data.

    The row is first, last, name, t, wall, wall_offset, data, and the checksum, if it has one.

    Raises:
        ValueError: it is damaged.
    """
    *columns, total = row
    if total is not None and total != checksum(tuple(columns)):
        raise ValueError("its bytes aren't those that were written")
    first, last, packed, t, wall, offset, text = columns
    count = last - first + 1
    try:
        numbers, times = unpack_numbers(packed, count), unpack_times(t, count)
        walls = times + offset if wall is None else unpack_times(wall, count)
        data = {int(i): more for i, more in json.loads(text).items()} if text else {}
    except (TypeError, KeyError, IndexError, AttributeError, RecursionError, zlib.error) as error:
        raise ValueError(f"{type(error).__name__}: {error}") from error
    if not (abs(times) <= _LONGEST).all() or not (abs(walls) <= _LONGEST).all():
        raise ValueError("it has times that are none")
    wanted = range(*part.indices(count))
    unknown = {number for number in numbers[part].tolist() if number not in names}
    if unknown:
        raise ValueError(f"what its events are of isn't there (numbers {', '.join(map(str, sorted(unknown)[:3]))})")
    rest = zip(wanted, numbers[part].tolist(), times[part].tolist(), walls[part].tolist(), strict=True)
    return [(i, at, on, names[n], sound(names[n][1], data.get(i, {}))) for i, n, at, on in rest]


Phase = Literal["running", "ended", "interrupted", "error"]


@dataclass(frozen=True)
class NodeState:
    """One node.

    Attributes:
        phase: running, ended with an outcome, interrupted, or it raised.
        since: when this phase began, on the run's clock [s].
    """

    phase: Phase
    since: float
    activations: int = 0
    outcome: str | None = None
    code: str | None = None
    message: str = ""


@dataclass
class RunSnapshot:
    """A run after some of its events.

    Attributes:
        nodes: path -> state, of nodes that were entered.
        variables: name -> the last event that wrote it.
        state: running, paused, stopping; or how the run has ended.
        seq: the last event taken in.
        t: its time on the run's clock [s].
    """

    nodes: dict[str, NodeState] = field(default_factory=dict)
    variables: dict[str, Event] = field(default_factory=dict)
    state: str = "running"
    seq: int = 0
    t: float = 0.0

    def apply(self, event: Event) -> None:
        """Take in the next event; kinds that aren't known change nothing."""
        self.seq, self.t = event.seq, event.t
        before = self.nodes.get(event.path)
        count = before.activations if before is not None else 0
        match event.event:
            case "enter":
                self.nodes[event.path] = NodeState("running", event.t, count + 1)
            case "exit":
                message = str(event.data.get("message", ""))
                self.nodes[event.path] = NodeState("ended", event.t, count, event.outcome, event.code, message)
            case "interrupted":
                self.nodes[event.path] = NodeState("interrupted", event.t, count)
            case "error":
                message = str(event.data.get("message", ""))
                self.nodes[event.path] = NodeState("error", event.t, count, message=message)
            case "message" if before is not None:
                self.nodes[event.path] = replace(before, message=str(event.data.get("text", "")))
            case "write":
                self.variables[str(event.data.get("variable"))] = event
            case "state":
                self.state = str(event.data.get("state"))
            case "run_resumed":
                self.state = "running"
                for path, node in self.nodes.items():
                    if node.phase == "error":  # its process died there; it runs on
                        self.nodes[path] = replace(node, phase="running", message="")
            case "run_ended":
                self.state = str(event.data.get("status"))

    def active(self) -> list[str]:
        return [path for path, node in self.nodes.items() if node.phase == "running"]
