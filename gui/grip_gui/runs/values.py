"""What a page shows of a value: a line, its parts, poses and points for drawing in space."""

from __future__ import annotations

import dataclasses
from base64 import b64encode
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import Any

import numpy as np

from grip_bt.base.values import DepthImage, Grasp, Image, JointState, PointCloud, Pose, RgbdFrame
from grip_bt.base.values.pose import angles_of
from grip_gui.runs.drawings import address, drawn_cloud, drawn_depth, fitted
from grip_gui.wire.runs import CloudView, NamedPlace, ValueView

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
