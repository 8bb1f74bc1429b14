"""Events as a journal has them, in columns of bytes; and what they add up to."""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

_ROW = np.dtype([("name", "<u4"), ("t", "<f8"), ("behind", "<f8")])
"""Of an event: the number of what it is of, its time on the run's clock, and how far the wall's is from that [s]."""
_SAME = 1e-3
"""Offsets of the run's clock from the wall's that differ by less than this [s] count as one."""


def packed(names: NDArray[np.int64], times: NDArray[np.float64], walls: NDArray[np.float64]) -> bytes:
    """Return the columns of a block, deflated: first all lowest bytes, ... last all highest, which hardly differ."""
    rows, behind = np.empty(len(names), _ROW), walls - times
    together = np.ptp(behind) < _SAME
    rows["name"], rows["t"], rows["behind"] = names, times, behind[0] if together else behind
    return zlib.compress(rows.view(np.uint8).reshape(-1, _ROW.itemsize).T.tobytes(), 1)


MOST = 65536
"""Most events in one block."""
Meaning = Literal["success", "failure"]
Name = tuple[str, str, str | None, str | None]
"""Of an event: path, kind, outcome and code."""


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


def checksum(first: int, last: int, content: object, data: object) -> int:
    """Return the CRC-32 of a block."""
    head = zlib.crc32(f"{first} {last} {data}".encode(errors="backslashreplace"))
    return zlib.crc32(content if isinstance(content, bytes) else repr(content).encode(), head)


def unpacked(
    row: tuple[Any, ...], names: Mapping[int, Name], part: slice
) -> list[tuple[int, float, float, Name, dict[str, object]]]:
    """Return what a block says of `part` of its events: index, time, wall time, what it is of, data.

    The row is first, last, content, data, and the checksum.

    Raises:
        ValueError: it is damaged.
        LookupError: what an event is of isn't among the names.
    """
    *said, total = row
    if total != checksum(*said):
        raise ValueError("its bytes aren't those that were written")
    first, last, content, text = said
    rows = (
        np.frombuffer(zlib.decompress(content), np.uint8).reshape(_ROW.itemsize, -1).T.copy().view(_ROW).ravel()[part]
    )
    data = json.loads(text) if text else {}
    wanted = range(*part.indices(last - first + 1))
    return [
        (i, at, at + behind, names[n], data.get(str(i), {}))
        for i, (n, at, behind) in zip(wanted, rows.tolist(), strict=True)
    ]


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
