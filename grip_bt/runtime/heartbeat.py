"""What a run's parent can see of it however it dies: a few bytes of memory that both share.

The run notes which node was entered last and which are active; a thread of it counts. A count that stands still means
that not even that thread gets its turn: code holds the interpreter.
"""

from __future__ import annotations

import mmap
import threading
from collections.abc import Mapping, Sequence

from grip_bt.base.values import Failure
from grip_bt.nodes.node import Silent

_BEAT = 0.1
"""How often the count goes on [s]."""
_COUNT, _LAST, _FLAGS = 0, 1, 8
LARGEST = 1 << 20
"""Size of the shared memory [bytes]; nodes beyond that aren't told apart."""


class Heartbeat(Silent):
    """The run's end: an observer of its nodes.

    Args:
        memory: file descriptor of at least `LARGEST` bytes.
        paths: the nodes, in an order that the parent knows too.
    """

    def __init__(self, memory: int, paths: Sequence[str]):
        shared = mmap.mmap(memory, LARGEST)
        room = LARGEST - _FLAGS - 1
        self._words, self._flags = memoryview(shared)[:_FLAGS].cast("I"), memoryview(shared)[_FLAGS:]
        self._numbers: Mapping[str, int] = {path: min(i, room) for i, path in enumerate(paths)}
        self._words[_LAST] = room
        self._over = threading.Event()

    def start(self) -> None:
        """Begin to count."""
        threading.Thread(target=self._beat, name="grip_pulse", daemon=True).start()

    def stop(self) -> None:
        """Count no more."""
        self._over.set()

    def _beat(self) -> None:
        while not self._over.wait(_BEAT):
            self._words[_COUNT] = (self._words[_COUNT] + 1) & 0xFFFFFFFF

    def entered(self, path: str) -> None:
        """Note where the run is."""
        number = self._numbers[path]
        self._words[_LAST] = number
        self._flags[number] = 1

    def ended(self, path: str, outcome: str, failure: Failure | None) -> None:
        """Note that it is there no more."""
        self._flags[self._numbers[path]] = 0

    def interrupted(self, path: str) -> None:
        """Likewise."""
        self._flags[self._numbers[path]] = 0


class HeartbeatReader:
    """The parent's end, which outlives the run.

    Args:
        memory: the same file descriptor.
    """

    def __init__(self, memory: int):
        self._shared = mmap.mmap(memory, LARGEST)

    @property
    def count(self) -> int:
        """How often the run's thread has counted."""
        return int.from_bytes(self._shared[:4], "little")

    def where(self, paths: Sequence[str]) -> tuple[str, list[str]]:
        """Return the node that was entered last, and the deepest nodes that were active, in the task's order."""
        last = int.from_bytes(self._shared[4:8], "little")
        active = [path for i, path in enumerate(paths) if i < LARGEST - _FLAGS - 1 and self._shared[_FLAGS + i]]
        deepest = [p for p in active if not any(q != p and (p == "/" or q.startswith(p + "/")) for q in active)]
        return (paths[last] if last < len(paths) else "/"), deepest
