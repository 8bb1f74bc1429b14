"""What a simulated world consists of, as frozen, checked values that travel as JSON; random tables drawn from a seed.

All poses are in world: the robot's base frame, z up, x forward. Lengths in m, masses in kg, times in s. What no world
can hold, such as a mass of -1 kg, is refused by pydantic's ValidationError, which names the field and what is allowed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field, TypeAdapter
from pydantic.dataclasses import dataclass

from grip_bt.base.values import CameraInfo, Pose

Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Vector = tuple[Finite, Finite, Finite]
Shade = Annotated[int, Field(ge=0, le=255)]
Colour = tuple[Shade, Shade, Shade]


def _rising(span: tuple[float, float]) -> tuple[float, float]:
    if not span[0] < span[1]:
        raise ValueError(f"from {span[0]:g} to {span[1]:g} is no range: the first number is the smaller one")
    return span


Range = Annotated[tuple[Finite, Finite], AfterValidator(_rising)]
GRAVITY = 9.81
"""[m/s^2]"""


@dataclass(frozen=True, slots=True)
class BoxSpec:
    """A box that never moves.

    Attributes:
        name: its entity's name.
        size: edge lengths [m].
        centre: its centre in world [m].
        colour: red green blue, 0-255.
    """

    name: str
    size: tuple[Positive, Positive, Positive]
    centre: Vector
    colour: Colour = (150, 150, 150)

    @property
    def low(self) -> Vector:
        """Smallest corner [m]."""
        return tuple(c - s / 2 for c, s in zip(self.centre, self.size, strict=True))  # type: ignore[return-value]

    @property
    def high(self) -> Vector:
        """Largest corner [m]."""
        return tuple(c + s / 2 for c, s in zip(self.centre, self.size, strict=True))  # type: ignore[return-value]


@dataclass(frozen=True, slots=True)
class ObjectSpec:
    """A rigid object that the robot may move; it starts upright.

    Attributes:
        name: its entity's name.
        shape: `cylinder` or `box`, the latter with a square foot.
        radius: radius, or half the edge of the foot [m].
        height: [m].
        position: where its centre starts, in world [m].
        yaw: turn about the vertical [rad].
        mass: [kg].
        friction: static and dynamic coefficient.
        colour: red green blue, 0-255.
    """

    name: str
    shape: Literal["cylinder", "box"]
    radius: Positive
    height: Positive
    position: Vector
    yaw: Finite = 0.0
    mass: Positive = 0.2
    friction: NotNegative = 1.0
    colour: Colour = (200, 60, 40)


@dataclass(frozen=True, slots=True)
class TableSpec:
    """A table whose top is at z = 0.

    Attributes:
        x: from, to [m].
        y: from, to [m].
        thickness: [m].
    """

    x: Range = (0.30, 1.00)
    y: Range = (-0.60, 0.60)
    thickness: Positive = 0.10
    colour: Colour = (176, 158, 130)

    def boxes(self) -> tuple[BoxSpec, ...]:
        """Return the boxes it consists of."""
        (x0, x1), (y0, y1), d = self.x, self.y, self.thickness
        centre = ((x0 + x1) / 2, (y0 + y1) / 2, -d / 2)
        return (BoxSpec("table", (x1 - x0, y1 - y0, d), centre, self.colour),)


@dataclass(frozen=True, slots=True)
class CrateSpec:
    """An open box whose floor is the table's top.

    Attributes:
        centre: x, y of its middle [m].
        inner: inner size in x and y [m].
        height: of the walls [m].
        wall: thickness of the walls [m].
    """

    centre: tuple[Finite, Finite] = (0.48, -0.40)
    inner: tuple[Positive, Positive] = (0.26, 0.30)
    height: Positive = 0.06
    wall: Positive = 0.01
    colour: Colour = (70, 110, 170)

    def boxes(self) -> tuple[BoxSpec, ...]:
        """Return its four walls."""
        (cx, cy), (ix, iy), h, w = self.centre, self.inner, self.height, self.wall
        dx, dy = (ix + w) / 2, (iy + w) / 2
        long_x, long_y = (ix + 2 * w, w, h), (w, iy, h)
        return (
            BoxSpec("crate_left", long_x, (cx, cy + dy, h / 2), self.colour),
            BoxSpec("crate_right", long_x, (cx, cy - dy, h / 2), self.colour),
            BoxSpec("crate_far", long_y, (cx + dx, cy, h / 2), self.colour),
            BoxSpec("crate_near", long_y, (cx - dx, cy, h / 2), self.colour),
        )

    def holds(self, point: Vector) -> bool:
        """Tell whether a point lies within the walls, seen from above."""
        offset = np.abs(np.subtract(point[:2], self.centre))
        return bool(np.all(offset < np.array(self.inner) / 2))


@dataclass(frozen=True, slots=True)
class CameraSpec:
    """A fixed RGB-D pinhole camera; by default one that looks straight down onto the pick region, image up = world +x.

    Attributes:
        name: the camera's name; its optical frame is `<name>_optical`.
        width: columns [px].
        height: rows [px].
        field_of_view: vertical opening angle [rad].
        position: of the optical centre, in world [m].
        quaternion: of the optical frame (x right, y down, z forward), w x y z.
        far: nothing is seen beyond [m].
    """

    name: str = "overhead"
    width: Annotated[int, Field(gt=0)] = 320
    height: Annotated[int, Field(gt=0)] = 240
    field_of_view: Annotated[float, Field(gt=0, lt=np.pi)] = 0.44
    position: Vector = (0.53, 0.14, 1.30)
    quaternion: tuple[Finite, Finite, Finite, Finite] = (0.0, 0.7071067811865476, -0.7071067811865476, 0.0)
    far: Positive = 3.0

    def info(self) -> CameraInfo:
        """Return the camera's geometry."""
        f = self.height / 2 / np.tan(self.field_of_view / 2)
        matrix = [[f, 0, self.width / 2], [0, f, self.height / 2], [0, 0, 1]]
        return CameraInfo(self.width, self.height, np.array(matrix), Pose(self.position, self.quaternion))


@dataclass(frozen=True, slots=True)
class WorldSpec:
    """Everything that makes a world: the same spec always makes the same world.

    Attributes:
        robot: a ready-made robot's name or a file; see `grip_bt.commanders.description.load.load_robot`.
        seed: what the objects were drawn from.
        objects: what may be moved.
        dt: time step of the physics [s].
        jerks: joint -> limit with which it is braked [rad/s^3 or m/s^3]; any for a motion of none of these.
    """

    robot: str = "panda_allegro"
    seed: int = 0
    objects: tuple[ObjectSpec, ...] = ()
    table: TableSpec = field(default_factory=TableSpec)
    crate: CrateSpec = field(default_factory=CrateSpec)
    cameras: tuple[CameraSpec, ...] = (CameraSpec(),)
    dt: Positive = 1 / 240
    jerks: Mapping[str, Positive] = field(default_factory=dict)

    def boxes(self) -> tuple[BoxSpec, ...]:
        """Return all boxes that never move."""
        return (*self.table.boxes(), *self.crate.boxes())

    def to_json(self) -> object:
        """Return the spec as JSON data."""
        return TypeAdapter(WorldSpec).dump_python(self, mode="json")

    @classmethod
    def from_json(cls, data: object) -> WorldSpec:
        """Return the spec that `to_json` wrote."""
        return TypeAdapter(cls).validate_python(data)


PICK_X, PICK_Y = (0.42, 0.64), (-0.08, 0.32)
RADIUS, HEIGHT, CLEARANCE = (0.028, 0.034), (0.14, 0.17), 0.15
COLOURS: tuple[Colour, ...] = ((205, 60, 45), (60, 150, 70), (225, 170, 40), (120, 70, 160), (30, 140, 160))


def table_world(seed: int, objects: int = 3) -> WorldSpec:
    """Return a table with a crate and random upright cylinders and boxes.

    Args:
        seed: the same seed gives the same world.
        objects: how many; centres are at least 0.15 m apart.

    Raises:
        ValueError: so many objects don't fit.
    """
    rng = np.random.default_rng(seed)
    places: list[np.ndarray] = []
    tries = 0
    while len(places) < objects:
        tries += 1
        if tries > 10_000:
            raise ValueError(f"{objects} objects don't fit at {CLEARANCE} m apart; take fewer (3 always fit)")
        place = rng.uniform((PICK_X[0], PICK_Y[0]), (PICK_X[1], PICK_Y[1]))
        if all(np.linalg.norm(place - other) >= CLEARANCE for other in places):
            places.append(place)
    return WorldSpec(seed=seed, objects=tuple(_object(rng, i, p) for i, p in enumerate(places)))


def _object(rng: np.random.Generator, index: int, place: np.ndarray) -> ObjectSpec:
    shape: Literal["cylinder", "box"] = "cylinder" if rng.random() < 0.5 else "box"
    radius, height = float(rng.uniform(*RADIUS)), float(rng.uniform(*HEIGHT))
    return ObjectSpec(
        name=f"{shape}_{index}",
        shape=shape,
        radius=radius,
        height=height,
        position=(float(place[0]), float(place[1]), height / 2),
        yaw=float(rng.uniform(-np.pi, np.pi)),
        mass=float(rng.uniform(0.18, 0.22)),
        colour=COLOURS[index % len(COLOURS)],
    )
