"""A client of action servers that isn't ours, in a process of its own: see `ros/data/plain_client.py`."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

PROGRAM = Path(__file__).parent / "ros" / "data" / "plain_client.py"


class PlainClient:
    """Sends goals, cancels them, and measures.

    Attributes:
        process: of the client; a test may kill it.
        names: the joints that it measures.
    """

    def __init__(self, process: subprocess.Popen[str], names: Sequence[str]):
        self.process, self.names = process, tuple(names)
        self.now: NDArray[np.float64] = np.array(self._answer()["ready"][2])

    def begin(self, points: Sequence[Any], after: float = 0.0, how: str | None = None) -> bool:
        """Send a goal; True when it is accepted, False when it is rejected."""
        assert self.process.stdin is not None
        self.process.stdin.write(json.dumps({"points": points, "after": after, "how": how}) + "\n")
        self.process.stdin.flush()
        return "accepted" in self._answer()

    def end(self) -> dict[str, Any]:
        """Return what became of it."""
        said = self._answer()
        if said["samples"]:
            self.now = np.array(said["samples"][-1][2])
        return said

    def move(self, points: Sequence[Any], after: float = 0.0, how: str | None = None) -> dict[str, Any]:
        """Send a goal and return what became of it."""
        assert self.begin(points, after, how)
        return self.end()

    def _answer(self) -> dict[str, Any]:
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        assert line, "the plain client has ended"
        answer: dict[str, Any] = json.loads(line)
        return answer


@contextmanager
def plain_client(
    action: str, kind: str, names: Sequence[str], domain: int, overlays: Sequence[Path] = ()
) -> Iterator[PlainClient]:
    """Run a plain client until the block ends.

    Args:
        action: of the server.
        kind: `trajectory`, `moveit` or `gripper`.
        names: the joints.
        domain: the DDS domain.
        overlays: prefixes with interface packages that it needs.
    """
    from grip_bt.ros.command import child_environment

    process = subprocess.Popen(
        [sys.executable, str(PROGRAM), action, kind, *names],
        env=child_environment(overlays, domain),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        yield PlainClient(process, names)
    finally:
        process.kill()
        process.wait()
        for pipe in (process.stdin, process.stdout):
            assert pipe is not None
            pipe.close()


def swing(start: NDArray[np.float64], goal: NDArray[np.float64], seconds: float) -> list[Any]:
    """Return points of a smooth motion from rest to rest, as [time, positions, velocities], 50 a second."""
    times = np.linspace(0.0, seconds, max(3, round(seconds * 50)) + 1)
    part = times / seconds
    way, pace = 10 * part**3 - 15 * part**4 + 6 * part**5, 30 * (part - part**2) ** 2 / seconds
    rows, speeds = start + np.outer(way, goal - start), np.outer(pace, goal - start)
    return [[float(t), q.tolist(), v.tolist()] for t, q, v in zip(times, rows, speeds, strict=True)]
