"""The record of a run's motion, read piece by piece while it grows, or afterwards."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from grip_bt.app.runs.motion_record import motion_file
from grip_gui.wire.live import MotionSample, MotionView

MOST = 1 << 20
"""Most that is read at once [bytes]."""


def motion_of(journal: Path, run: str, after: int) -> MotionView:
    """Return the next piece of a record; an empty one where there is none.

    Args:
        journal: that the run is in.
        run: its id.
        after: where the last piece ended.
    """
    file = motion_file(journal, run)
    if not file.is_file():
        return MotionView(samples=[], next=0)
    with file.open("rb") as record:
        record.seek(after)
        piece = record.read(MOST)
    whole = piece[: piece.rfind(b"\n") + 1]  # the last line may be being written
    parts: dict[str, list[str]] = {}
    samples = []
    bodies: dict[str, Any] = {}
    for line in whole.splitlines():
        data: dict[str, Any] = json.loads(line)
        if "parts" in data:
            parts = data["parts"]
        else:
            bodies |= data.pop("bodies", {})
            samples.append(MotionSample(**data))
    return MotionView(parts=parts, bodies=bodies, samples=samples, next=after + len(whole))


def last_state(journal: Path, run: str, part: str) -> dict[str, float]:
    """Return where a part was measured last: joint -> position [rad or m]; empty where it never was."""
    joints: list[str] = []
    positions: list[float] = []
    after, piece = 0, None
    while piece is None or piece.next > after:
        after = 0 if piece is None else piece.next
        piece = motion_of(journal, run, after)
        joints = piece.parts.get(part, joints)
        positions = next((s.q[part] for s in reversed(piece.samples) if part in s.q), positions)
    return dict(zip(joints, positions, strict=False))
