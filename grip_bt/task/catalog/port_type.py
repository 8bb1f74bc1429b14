"""Types of a component's ports: numbers with their units, grasps in the component's own convention."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, StringConstraints, model_validator

from grip_bt.base.yaml.models import Identifier, Settings

UNITS: dict[str, float] = {
    **{"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254},
    **{"rad": 1.0, "deg": math.pi / 180},
    **{"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    **{"kg": 1.0, "g": 1e-3, "N": 1.0, "Nm": 1.0, "percent": 0.01},
}
"""Units that a component may use, in those of GRIP (m, rad, s, kg, N, N m, fractions)."""
Unit = Literal["m", "cm", "mm", "in", "rad", "deg", "s", "ms", "us", "ns", "kg", "g", "N", "Nm", "percent"]
_FieldPath = Annotated[str, StringConstraints(pattern=r"^[a-z][a-z0-9_]*(\.[a-z][a-z0-9_]*)*$")]

AXES = ("x", "y", "z", "-x", "-y", "-z")
"""Axes of a pose along which a component may approach or close."""
LENGTHS = ("m", "cm", "mm", "in")
_SignedPath = Annotated[str, StringConstraints(pattern=r"^-?[a-z][a-z0-9_]*(\.[a-z][a-z0-9_]*)*$")]


class Number(Settings):
    """A number in a component's message; its field's name alone will do."""

    field: _SignedPath
    """Where it is in the message; after a minus, it is negated."""
    unit: Unit | Literal["px"] | None = None
    """Unit that the component uses; `px` of the width of a line in an image."""

    @model_validator(mode="before")
    @classmethod
    def _short(cls, value: object) -> object:
        return {"field": value} if isinstance(value, str) else value


class GraspFields(Settings):
    """How a message says a grasp: a pose, a point with two vectors, or a line in an image; or it is a pose itself."""

    pose: _FieldPath | None = None
    """Field with a Pose, PoseStamped or Transform."""
    position: _FieldPath | None = None
    """Field with a point, or 3 numbers; `approach` and `closing` are fields too then."""
    column: Number | None = None
    """Of a line in the image of `camera`, along whose optical axis the approach is: its middle; the first is 0."""
    row: Number | None = None
    """Likewise, counted downwards."""
    angle: Number | None = None
    """From the image's right to the line along which the fingers close, turning towards its lower edge."""
    depth: Number | None = None
    """Of its middle along the optical axis; by default that of the depth image that was sent."""
    approach: _SignedPath = "z"
    """Where the hand goes: an axis of the pose, or a field with a vector; a minus turns it round."""
    closing: _SignedPath = "y"
    """Along which the fingers close, likewise."""
    offset: float = 0.0
    """From what is said to the point between the finger tips, along the approach [m]."""
    width: Number | None = None
    """Of the thing between the fingers."""
    quality: Number | None = None
    """Larger is better."""
    camera: Identifier | None = None
    """The input with a depth image, a frame or a camera's geometry in whose optical frame the grasps are given."""
    standoff: float = Field(default=0.12, gt=0)
    """Length of the straight approach [m]."""
    lift: float = Field(default=0.15, ge=0)
    """Height of the straight lift [m]."""

    @model_validator(mode="after")
    def _one_way(self) -> GraspFields:
        ways = [name for name in ("pose", "position", "column") if getattr(self, name) is not None]
        way, said = ways[0] if ways else "pose", (self.approach, self.closing)
        if len(ways) > 1:
            raise ValueError(f"`{ways[0]}` and `{ways[1]}` are two ways to say a grasp: give one of them")
        directed = {"approach", "closing"} & self.model_fields_set
        if way == "column" and (None in (self.row, self.angle, self.camera) or directed):
            raise ValueError("`column` needs `row`, `angle` and `camera`, and neither `approach` nor `closing`")
        if way == "position" and not {*said}.isdisjoint(AXES):
            raise ValueError("`position` needs `approach` and `closing`, fields with a vector each: it has no axes")
        if way == "pose" and (wrong := [axis for axis in said if axis not in AXES]):
            raise ValueError(f"{wrong[0]!r} isn't an axis of a pose: write one of {', '.join(AXES)}")
        if way == "pose" and said[0][-1] == said[1][-1]:
            raise ValueError("`approach` and `closing` are two axes at right angles, such as z and y")
        widths = (*LENGTHS, "px") if way == "column" else LENGTHS
        units = {"angle": ("rad", "deg"), "width": widths, "depth": LENGTHS}
        for name, number in self.numbers().items():
            if number.unit not in (None, *units.get(name, ())):
                raise ValueError(f"{name}: {number.unit!r} isn't one of its units: {', '.join(units.get(name, ()))}")
        return self

    def numbers(self) -> dict[str, Number]:
        """Return each key whose field holds one number."""
        given = ((name, getattr(self, name)) for name in ("column", "row", "angle", "depth", "width", "quality"))
        return {name: number for name, number in given if number is not None}


class PortType(Settings):
    """A field of the interface as a port of the node, and how it is converted on the way."""

    type: str = Field(min_length=1)
    """Name of a value (`PointCloud`, `list[Grasp]`), a builtin, or a ROS type, which leaves the message as it is."""
    doc: str = ""
    """A sentence about the port."""
    field: _FieldPath | None = None
    """Where it is in the message, such as `target.pose`; the field of the port's own name by default."""
    unit: Unit | None = None
    """Unit that the component uses; a port's own is always m, rad, s, kg, N or a fraction."""
    quaternion: Literal["xyzw", "wxyz"] | None = None
    """Order in which the component writes a rotation into an array of numbers; `xyzw` by default."""
    frame: str | None = None
    """Frame that the component works in: what goes in is transformed into it, what comes out without a frame has it."""
    grasp: GraspFields | None = None
    """How the component's messages say the grasps of an output, which become those of a hand, in world."""

    @property
    def adapts(self) -> bool:
        """Whether the value is changed between port and field."""
        return self.unit is not None or self.quaternion is not None or self.frame is not None

    @model_validator(mode="after")
    def _of_grasps(self) -> PortType:
        if self.grasp is not None and self.type not in ("Grasp", "list[Grasp]"):
            raise ValueError(f"`grasp` says what a `Grasp` or a `list[Grasp]` is made of; this is `{self.type}`")
        return self
