"""Other people's grasps as GRIP's: whatever their messages, frames, units and axes are, by what a component file says.

A grasp comes out as one of a hand that goes along its z and closes along its y, with its origin between the finger
tips, in world.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.values import CameraInfo, DepthImage, Grasp, Pose, RgbdFrame
from grip_bt.task.catalog.port_type import AXES, UNITS, Number, PortType

from .client.types import ConversionError, check_field
from .convert import each, from_message
from .frames import ROOT, FrameError, FrameTree

_AXES = dict(zip(AXES, (*np.eye(3), *-np.eye(3)), strict=True))
_PARALLEL = 1e-3
"""Sine of the least angle between an approach and the line along which fingers close; also the shortest vector."""
_Told = tuple[Array, Array, Array, float]
"""A point [m], the approach, the closing line, shape (3,) each, in the component's frame; the width of a pixel [m]."""


class GraspReader:
    """Reads the grasps of a port.

    Args:
        around: the frame of the message around them, if any.
        request: what they are an answer to, for the input that the port calls its `camera`.
        component: name for the grasps' `provenance`.
    """

    def __init__(self, port: PortType, around: str, request: Mapping[str, object], frames: FrameTree, component: str):
        assert port.grasp is not None, "a port of grasps"
        self._said, self._several, self._component = port.grasp, port.type.startswith("list"), component
        self._scale = UNITS[port.unit] if port.unit else 1.0
        self._frame, self._frames = around or port.frame or ROOT, frames
        seen = request.get(port.grasp.camera or "")
        view = seen.depth if isinstance(seen, RgbdFrame) else seen
        self._depth = view.depth if isinstance(view, DepthImage) else np.zeros((0, 0))
        self._info = view.info if isinstance(view, DepthImage) else view if isinstance(view, CameraInfo) else None

    def read(self, raw: Any) -> Grasp | list[Grasp]:
        """Return what a field holds.

        Raises:
            ConversionError: a field isn't there or isn't what is said; a frame isn't known.
        """
        return cast("list[Grasp]", each(raw, self._grasp)) if self._several else self._grasp(raw)

    def _grasp(self, item: Any) -> Grasp:
        said = self._said
        if said.camera is not None and self._info is None:
            raise ConversionError(
                "", f"nothing was sent as {said.camera!r}, the camera in whose frame grasps are given"
            )
        told = {name: _number(item, number) for name, number in said.numbers().items()}
        point, approach, closing, pixel = self._drawn(told) if said.column is not None else self._in_space(item)
        across = np.cross(closing, approach)
        if np.linalg.norm(across) < _PARALLEL:
            raise ConversionError("", "`approach` and `closing` are parallel, which makes no grasp")
        across /= np.linalg.norm(across)
        matrix = np.eye(4)
        matrix[:3] = np.stack([across, np.cross(approach, across), approach, point + said.offset * approach], axis=1)
        pose = self._in_world(Pose.from_matrix(matrix), item)
        back, up = -said.standoff * pose.rotation()[:, 2], (0.0, 0.0, said.lift)
        width = told.get("width", 0.0) * (pixel if said.width is not None and said.width.unit == "px" else 1.0)
        ways, quality = (pose, pose.moved(back), pose.moved(up)), told.get("quality", 0.0)
        return Grasp(*ways, width=width, quality=quality, provenance=self._component)

    def _in_space(self, item: Any) -> _Told:
        said = self._said
        if said.position is not None:
            point = _vector(item, said.position) * self._scale
            return point, _direction(item, said.approach), _direction(item, said.closing), 0.0
        pose: Pose = from_message(_at(item, said.pose) if said.pose else item, "Pose")
        turned = pose.rotation()
        return pose.position * self._scale, turned @ _AXES[said.approach], turned @ _AXES[said.closing], 0.0

    def _drawn(self, told: Mapping[str, float]) -> _Told:
        info, column, row = self._info, told["column"], told["row"]
        assert info is not None, "asked before"
        inside = 0 <= round(row) < len(self._depth) and 0 <= round(column) < info.width
        away = told["depth"] if "depth" in told else float(self._depth[round(row), round(column)]) if inside else 0.0
        if away <= 0:
            raise ConversionError("", f"no depth is known at column {column:g}, row {row:g}")
        focal, middle = np.diag(info.matrix)[:2], info.matrix[:2, 2]
        spot = away * np.array([*((np.array([column, row]) + 0.5 - middle) / focal), 1.0])
        line = np.array([np.cos(told["angle"]), np.sin(told["angle"]), 0.0]) / [*focal, 1.0]
        length = float(np.linalg.norm(line))
        return spot, _AXES["z"], line / length, away * length

    def _in_world(self, pose: Pose, item: Any) -> Pose:
        frame = frame_id(_at(item, self._said.pose) if self._said.pose else item) or frame_id(item) or self._frame
        if self._info is not None:
            pose, frame = self._info.pose @ pose, self._info.pose.frame
        try:
            return self._frames.lookup(ROOT, frame) @ pose
        except FrameError as error:
            reason = f"grasps are given in {frame!r}, whose place in world isn't known: {error.message}"
            raise ConversionError("", f"{reason}; give `frame`, or the input that is their `camera`") from None


def frame_id(message: object) -> str:
    """Return the frame that a message's own header names; empty where there is none."""
    return str(getattr(getattr(message, "header", None), "frame_id", ""))


def _at(item: Any, path: str) -> Any:
    for name in path.split("."):
        check_field(type(item), name)
        item = getattr(item, name)
    return item


def _number(item: Any, said: Number) -> float:
    """Return the number in a field, in GRIP's units; pixels as they are."""
    path = said.field.removeprefix("-")
    value = float(from_message(_at(item, path), float)) * UNITS.get(said.unit or "", 1.0)
    if not np.isfinite(value):
        raise ConversionError(path, f"{value} is no number")
    return -value if said.field.startswith("-") else value


def _vector(item: Any, path: str) -> Array:
    """Return a point, a vector or 3 numbers as an array of shape (3,)."""
    raw = _at(item, path)
    numbers = np.array([raw.x, raw.y, raw.z] if hasattr(raw, "z") else raw, dtype=float)
    if numbers.shape != (3,) or not np.isfinite(numbers).all():
        raise ConversionError(path, f"it needs 3 numbers, not {numbers.tolist()}")
    return numbers


def _direction(item: Any, path: str) -> Array:
    vector = _vector(item, path.removeprefix("-"))
    length = float(np.linalg.norm(vector))
    if length < _PARALLEL:
        raise ConversionError(path.removeprefix("-"), "the vector has no direction: it is 0 long")
    return vector / (-length if path.startswith("-") else length)
