"""Runs, their events and values for the page, out of the project's journal: the live view and the replay read the same.

A value is looked at as a line, its parts, and a drawing where one helps.
"""

from __future__ import annotations

import dataclasses
import struct
import threading
import zlib
from base64 import b64encode
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grip_bt.base.errors import GripError, UnknownNameError
from grip_bt.base.values import DepthImage, Grasp, Image, JointState, PointCloud, Pose, RgbdFrame
from grip_bt.base.values.pose import angles_of
from grip_bt.runtime import Event, JournalError, JournalReader
from grip_bt.runtime import RunRecord as JournalRecord
from grip_gui.wire.runs import CloudView, NamedPlace, RunEvent, RunRecord, ValueView

LISTED = 100  # most runs that are offered


class JournalRuns:
    """The runs of a journal file; as long as there is no file there are no runs. Safe to use from several threads.

    The paths of their tasks are relative to the project folder.
    """

    def __init__(self, file: Path, folder: Path):
        self.file, self._folder = file, folder
        self._lock = threading.Lock()
        self._opened: JournalReader | None = None

    def runs(self) -> list[RunRecord]:
        """Return the latest runs, newest first."""
        reader = self._reader()
        return [self._wire(record) for record in reader.runs()[:LISTED]] if reader else []

    def run(self, run: str) -> RunRecord:
        """Return one run; UnknownNameError where there is none."""
        return self._wire(self._find(run))

    def task_text(self, run: str) -> str:
        """Return the task file as it was when the run started."""
        return self._find(run).task_text

    def events(self, run: str, from_seq: int, limit: int) -> list[RunEvent]:
        """Return at most `limit` events from `from_seq` on, in order."""
        reader = self._reader()
        found = [] if reader is None else reader.events(run, from_seq - 1, limit)
        return [RunEvent.model_validate(event) for event in found]  # without the outcomes' meaning: pages know the task

    def value(self, run: str, seq: int) -> ValueView:
        """Return what the write with this number wrote, for looking at."""
        reader, event = self._write_of(run, seq)
        type_name = str(event.data.get("type", ""))
        try:
            return value_view(type_name, reader.value(event))
        except GripError as error:  # too big, of a class that can't be restored, or written by an earlier version
            text = str(event.data.get("preview", ""))
            return ValueView(type=type_name, text=text, rows=[["not kept", str(error)]])

    def raw(self, run: str, seq: int) -> Any:
        """Return what the write with this number wrote, as it was."""
        reader, event = self._write_of(run, seq)
        return reader.value(event)

    def _write_of(self, run: str, seq: int) -> tuple[JournalReader, Event]:
        reader = self._reader()
        found = [] if reader is None else reader.events(run, seq - 1, 1)
        if reader is None or not found or found[0].seq != seq or found[0].event != "write":
            raise UnknownNameError("write of a variable", str(seq), (), f"the run {run}")
        return reader, found[0]

    def _find(self, run: str) -> JournalRecord:
        reader = self._reader()
        if reader is None:
            raise UnknownNameError("run", run, ())
        return reader.run(run)

    def _reader(self) -> JournalReader | None:
        with self._lock:
            if self._opened is None and self.file.is_file():
                try:
                    self._opened = JournalReader(self.file)
                except JournalError as error:
                    if "no such table" not in str(error):
                        raise
                    # A run has just made the file and is about to make its tables.
            return self._opened

    def _wire(self, record: JournalRecord) -> RunRecord:
        path = Path(record.task_path)
        if path.is_relative_to(self._folder):
            record = dataclasses.replace(record, task_path=path.relative_to(self._folder).as_posix())
        return RunRecord.model_validate(record)


# --- values -----------------------------------------------------------------------------------------------------------

ROWS = 60  # most parts that are listed
PLACES = 30  # most poses that are drawn
POINTS = 20_000  # most points of a cloud that are drawn in space
LINE = 300  # longest text of a part, in characters


def value_view(type_name: str, value: object) -> ValueView:
    """Return what a page shows of a value, of a type that the journal calls `type_name`."""
    rows = [[name, _line(part)] for name, part in islice(_parts(value), ROWS + 1)]
    rows[ROWS:] = [["...", "there is more"]] if len(rows) > ROWS else []
    picture, caption = _drawing(value)
    places = [
        NamedPlace(name=name, frame=pose.frame, at=[*pose.position.tolist(), *pose.quaternion.tolist()])
        for name, pose in islice(_poses(value), PLACES)
    ]
    return ValueView(type=type_name, text=_line(value), rows=rows, picture=picture, caption=caption, places=places)


def cloud_view(value: object) -> CloudView:
    """Return the points of a cloud, or of what a camera with depth saw; without any for other values."""
    if isinstance(value, RgbdFrame):
        value = value.cloud()
    if not isinstance(value, PointCloud):
        return CloudView()
    seen = np.flatnonzero(np.isfinite(value.points).all(axis=1))
    kept = seen[:: max(1, -(-len(seen) // POINTS))]
    return CloudView(
        frame=value.frame,
        points=b64encode(value.points[kept].astype("<f4").tobytes()).decode(),
        colors="" if value.colors is None else b64encode(value.colors[kept].tobytes()).decode(),
        of=len(value.points),
    )


def _drawing(value: object) -> tuple[str, str]:
    match value:
        case PointCloud(points=points, colors=colors):
            size = np.ptp(points, axis=0) if len(points) else np.zeros(3)
            extent = " x ".join(f"{side:.3g}" for side in size)
            return address(drawn_cloud(points, colors)), f"{len(points)} points from above, {extent} m, {value.frame}"
        case Image(pixels=pixels):
            picture = np.ascontiguousarray(fitted(pixels), dtype=np.uint8)
            return address(picture), f"{pixels.shape[1]} x {pixels.shape[0]} pixels"
        case DepthImage(depth=depth):
            seen = depth[depth > 0]
            reach = f"{seen.min():.3g} to {seen.max():.3g} m" if seen.size else "nothing seen"
            return address(drawn_depth(depth)), f"{depth.shape[1]} x {depth.shape[0]} pixels, {reach}"
    return "", ""


def _parts(value: object) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Pose):
        yield "position", value.position
        yield "quaternion", value.quaternion
        yield "frame", value.frame
        yield "turns", _turns(value)
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield field.name, getattr(value, field.name)
    elif isinstance(value, Mapping):
        yield from ((str(key), part) for key, part in value.items())
    elif isinstance(value, Sequence) and not isinstance(value, str | bytes):
        yield from ((str(i), part) for i, part in enumerate(value))


def _poses(value: Any, name: str = "") -> Iterator[tuple[str, Pose]]:
    """Yield the poses in a value, by what they are."""
    match value:
        case Pose():
            yield name, value
        case Grasp(pose=pose, pre_grasp=before, post_grasp=after):
            for when, at in (("grasp", pose), ("before", before), ("after", after)):
                yield f"{name} {when}".strip(), at
        case Mapping():
            for key, part in value.items():
                yield from _poses(part, str(key))
        case list() | tuple():
            for number, part in enumerate(value):
                yield from _poses(part, str(number))


def _line(value: object) -> str:
    """Return a value in one line."""
    match value:
        case Pose():
            return f"at {_numbers(value.position)} m in {value.frame}, {_turns(value)}"
        case JointState():
            text = ", ".join(f"{name} {at:.4g}" for name, at in zip(value.names, value.position, strict=True))
        case np.ndarray() if value.size <= 12:
            return _numbers(value.ravel())
        case np.ndarray():
            return f"{' x '.join(map(str, value.shape))} of {value.dtype}"
        case float():
            return f"{value:.6g}"
        case str():
            text = value
        case _:
            text = repr(value)
    return text if len(text) <= LINE else text[: LINE - 3] + "..."


def _numbers(values: Iterable[float]) -> str:
    return "(" + ", ".join(f"{float(v):.4g}" for v in values) + ")"


def _turns(pose: Pose) -> str:
    """Return a rotation as roll, pitch, yaw: about the fixed axes x, y, z [deg]."""
    turns = np.degrees(angles_of(pose.rotation()))
    return "roll {:.1f}, pitch {:.1f}, yaw {:.1f} deg".format(*turns.round(1) + 0.0)


Pixels = NDArray[np.uint8]
LARGEST = 320  # longest side of a drawing [px]
DARK = 24  # background of clouds, of 255


def png(pixels: Pixels) -> bytes:
    """Return pixels of shape (height, width, 3) as a PNG file."""
    rows = np.insert(pixels.reshape(len(pixels), -1), 0, 0, axis=1)  # each begins with its filter: none
    head = struct.pack(">2I5B", pixels.shape[1], len(pixels), 8, 2, 0, 0, 0)
    parts = (b"IHDR" + head, b"IDAT" + zlib.compress(rows.tobytes(), 1), b"IEND")
    framed = (struct.pack(">I", len(part) - 4) + part + struct.pack(">I", zlib.crc32(part)) for part in parts)
    return b"\x89PNG\r\n\x1a\n" + b"".join(framed)


def address(pixels: Pixels) -> str:
    """Return pixels as a `data:` address for a page."""
    return "data:image/png;base64," + b64encode(png(pixels)).decode()


def fitted(pixels: NDArray[np.generic]) -> NDArray[np.generic]:
    """Return an image so that its longer side has at most `LARGEST` pixels, by leaving rows and columns out."""
    step = max(1, -(-max(pixels.shape[:2]) // LARGEST))
    return pixels[::step, ::step]


def drawn_depth(depth: NDArray[np.float32]) -> Pixels:
    """Return depth as grey: near is light, nothing seen is dark blue."""
    small = np.asarray(fitted(depth), dtype=float)
    seen = np.isfinite(small) & (small > 0)
    picture = np.full((*small.shape, 3), (16, 16, 48), dtype=np.uint8)
    if seen.any():
        low, high = small[seen].min(), small[seen].max()
        picture[seen] = (255 - 215 * (small[seen] - low) / max(high - low, 1e-9)).astype(np.uint8)[:, None]
    return picture


def drawn_cloud(points: NDArray[np.float32], colors: Pixels | None = None) -> Pixels:
    """Return a cloud seen from above, x to the right and y upwards; the highest point of a pixel is seen.

    Args:
        points: shape (n, 3) [m].
        colors: shape (n, 3), or None to colour by height.
    """
    finite = np.isfinite(points).all(axis=1)
    xyz, side = points[finite].astype(float), LARGEST // 2
    picture = np.full((side, side, 3), DARK, dtype=np.uint8)
    if not len(xyz):
        return picture
    low, high = xyz.min(axis=0), xyz.max(axis=0)
    scale = (side - 1) / max(float((high - low)[:2].max()), 1e-6)
    column = ((xyz[:, 0] - low[0]) * scale).astype(int)
    row = side - 1 - ((xyz[:, 1] - low[1]) * scale).astype(int)
    if colors is not None:
        shade = colors[finite]
    else:
        height = (xyz[:, 2] - low[2]) / max(float(high[2] - low[2]), 1e-6)
        shade = np.stack([60 + 195 * height, 120 + 100 * (1 - np.abs(2 * height - 1)), 255 - 195 * height], axis=1)
    order = np.argsort(xyz[:, 2], kind="stable")  # the last write of a pixel stays: the highest point
    picture[row[order], column[order]] = shade[order].astype(np.uint8)
    return picture
