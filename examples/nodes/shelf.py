"""Nodes of this project: one of each kind. They are found without being run, and are imported when a task uses them."""

from __future__ import annotations

import asyncio
from pathlib import Path

import numpy as np

import grip_bt as grip
from grip_bt.base.failures import TimeOutError
from grip_bt.base.values import PointCloud, Pose


@grip.leaf("shelf/height", outputs={"height": float})
def height(cloud: PointCloud, *, percentile: float = 99.0) -> float:
    """Say how high what a cloud shows reaches [m]. It runs in a worker, since clouds are large."""
    return float(np.percentile(cloud.points[:, 2], percentile))


@grip.leaf("shelf/is_room", outcomes={"room": "success", "too_high": "failure"}, codes=("too_high",), quick=True)
def is_room(height: float, *, limit: float = 0.3) -> grip.End:
    """Compare a height with the shelf's. It is called in the tick itself, since it takes microseconds."""
    if height <= limit:
        return grip.End("room")
    return grip.End("too_high", code="too_high", message=f"{height:.2f} m are more than {limit:.2f} m")


@grip.leaf("shelf/wait_for_go", codes=("time_out",))
async def wait_for_go(context: grip.Context, *, file: str, timeout: float = 60.0, period: float = 0.1) -> None:
    """Wait until somebody has made a file. It is a coroutine, so that it can be cancelled while it waits."""
    end = context.clock.now() + timeout
    while not Path(file).exists():
        if context.clock.now() >= end:
            raise TimeOutError(f"nobody has made {file} within {timeout:g} s")
        await asyncio.sleep(period)


@grip.leaf("shelf/next_slot", outcomes={"slot": "success", "full": "failure"}, codes=("full",))
class NextSlot(grip.Leaf):
    """Hand out the slots of a board, one after the other: a leaf with a memory, ticked like any other."""

    corner: grip.Input[Pose]
    columns: grip.Param[int] = 3
    rows: grip.Param[int] = 2
    pitch: grip.Param[float] = 0.1
    slot: grip.Output[Pose]

    def prepare(self) -> None:
        """Begin with the first slot of the run."""
        self._taken = 0

    def update(self) -> grip.Status:
        """Give the next slot."""
        if self._taken == self.columns * self.rows:
            return self.fail("full", f"all {self._taken} slots are taken", outcome="full")
        row, column = divmod(self._taken, self.columns)
        self._taken += 1
        return self.end("slot", slot=self.corner.moved((column * self.pitch, row * self.pitch, 0.0)))
