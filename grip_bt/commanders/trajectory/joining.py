"""Trajectories one after the other, as one."""

from __future__ import annotations

import numpy as np

from grip_bt.base.values import Trajectory


def joined(pieces: list[Trajectory]) -> Trajectory:
    """Return trajectories of the same joints, each of which begins at rest where the one before ends, as one."""
    first, *more = pieces
    times, end = [first.times], first.duration
    for piece in more:
        times.append(piece.times[1:] + end)
        end += piece.duration
    rows = {
        name: np.concatenate([getattr(first, name), *(getattr(piece, name)[1:] for piece in more)])
        for name in ("positions", "velocities", "accelerations")
    }
    return Trajectory(first.names, np.concatenate(times), **rows)
