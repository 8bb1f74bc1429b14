"""What a simulated world consists of, as frozen, checked values that travel as JSON.

All poses are in world: the robot's base frame, z up, x forward. Lengths in m, masses in kg, times in s; a size is edge
lengths, a yaw a turn about the vertical [rad], a colour red green blue, 0-255; names are entities'. What no world
can hold, such as a mass of -1 kg, is refused by pydantic's ValidationError, which names the field and what is allowed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import field
from typing import Annotated, Literal, TypeAlias

import numpy as np
from pydantic import Field, TypeAdapter
from pydantic.dataclasses import dataclass

from grip_bt.base.values import CameraInfo, Pose
from grip_bt.base.values.pose import quaternion_of
from grip_bt.base.yaml.models import Finite, NotNegative, Positive
from grip_sim.articulated.model import ArticulatedConfig, Size, Vector
from grip_sim.faults import Fault
from grip_sim.liquids import VesselConfig
from grip_sim.noise import Noise
from grip_sim.shaking import MEASURE, ShakeConfig

Shade = Annotated[int, Field(ge=0, le=255)]
Colour = tuple[Shade, Shade, Shade]


VOLUME, SPILLED = "{}_volume", "spilled"
"""What the referee calls the volume in a vessel, and what is in none any more [ml]."""
GRAVITY = 9.81
"""[m/s^2]"""
Boxes: TypeAlias = "tuple[BoxSpec, ...]"


@dataclass(frozen=True, slots=True)
class BoxSpec:
    """A box that never moves.

    Attributes:
        centre: its centre in world [m].
        yaw: turn about the vertical [rad], after the pitch.
        pitch: turn about y, a slope that falls towards +x [rad].
    """

    name: str
    size: Size
    centre: Vector
    colour: Colour = (150, 150, 150)
    yaw: Finite = 0.0
    pitch: Finite = 0.0

    @property
    def pose(self) -> Pose:
        """Its centre in world."""
        return Pose(self.centre, quaternion_of(0.0, self.pitch, self.yaw))


@dataclass(frozen=True, slots=True)
class MeshSpec:
    """Triangles that never move, such as a rack or a part of a room.

    Attributes:
        file: path of a mesh: obj, stl, ply or dae.
        position: of the mesh's origin in world [m].
    """

    name: str
    file: str
    position: Vector
    yaw: Finite = 0.0
    scale: Positive = 1.0
    colour: Colour = (150, 150, 150)

    @property
    def pose(self) -> Pose:
        """Its origin in world."""
        return upright(self.position, self.yaw)


@dataclass(frozen=True, slots=True)
class RegionSpec:
    """An upright box of space with a name, which tasks aim at and the referee judges by.

    Attributes:
        target: whether an object at rest in it counts as placed.
    """

    name: str
    size: Size
    centre: Vector
    yaw: Finite = 0.0
    target: bool = False

    @property
    def pose(self) -> Pose:
        """Its centre in world."""
        return upright(self.centre, self.yaw)

    def holds(self, point: Iterable[float]) -> bool:
        """Tell whether a point in world [m] lies in it."""
        return bool(np.all(np.abs(self.pose.inverse().apply([tuple(point)])[0]) <= np.array(self.size) / 2))


@dataclass(frozen=True, slots=True)
class ObjectSpec:
    """A rigid object that the robot may move; it starts upright unless it is tilted.

    Attributes:
        shape: `cylinder`, `box` with a square foot, `sphere`, or `model`.
        radius: radius, or half the edge of the foot; of a model, that of the circle it stays within [m].
        height: [m]; a sphere's is twice its radius.
        position: where its centre starts, in world [m]; a model's is the middle of its bounding box.
        yaw: turn about the vertical [rad], after the tilt.
        friction: coefficient against hands and everything that never moves. Between two objects theirs are added.
        tilt: roll and pitch [rad].
        scale: factor of a model's lengths.
        vessel: its inside, where liquids may be in it.
    """

    name: str
    shape: Literal["cylinder", "box", "sphere", "model"]
    radius: Positive
    height: Positive
    position: Vector
    yaw: Finite = 0.0
    mass: Positive = 0.2
    friction: NotNegative = 1.0
    colour: Colour = (200, 60, 40)
    tilt: tuple[Finite, Finite] = (0.0, 0.0)
    model: str = ""
    scale: Positive = 1.0
    vessel: VesselConfig | None = None

    @property
    def pose(self) -> Pose:
        """Where its centre starts, in world."""
        return Pose(self.position, quaternion_of(*self.tilt, self.yaw))


def upright(position: Iterable[float], yaw: float) -> Pose:
    """Return a pose in world that is turned about the vertical only [m, rad]."""
    return Pose(tuple(position), quaternion_of(0.0, 0.0, yaw))


TABLE = BoxSpec("table", (0.70, 1.20, 0.10), (0.65, 0.0, -0.05), (176, 158, 130))
"""Its top is at z = 0."""


def open_box(name: str, inner: Size, at: Vector, wall: float = 0.01, colour: Colour = (70, 110, 170)) -> Boxes:
    """Return the four walls of a box without lid and floor.

    Args:
        name: its walls are called `NAME_left`, `_right`, `_far` and `_near`.
        inner: inner size in x and y, and height of the walls [m].
        at: the middle of the inside's floor, in world [m].
    """
    (ix, iy, h), (x, y, z) = inner, at
    dx, dy, middle = (ix + wall) / 2, (iy + wall) / 2, z + h / 2
    long_x, long_y = (ix + 2 * wall, wall, h), (wall, iy, h)
    return (
        BoxSpec(f"{name}_left", long_x, (x, y + dy, middle), colour),
        BoxSpec(f"{name}_right", long_x, (x, y - dy, middle), colour),
        BoxSpec(f"{name}_far", long_y, (x + dx, y, middle), colour),
        BoxSpec(f"{name}_near", long_y, (x - dx, y, middle), colour),
    )


@dataclass(frozen=True, slots=True)
class CameraSpec:
    """An RGB-D pinhole camera; by default one that looks straight down onto the pick region, image up = world +x.

    Attributes:
        name: the camera's name; its optical frame is `<name>_optical`.
        field_of_view: vertical opening angle [rad].
        position: of the optical centre, in world or in the link [m].
        quaternion: of the optical frame (x right, y down, z forward), w x y z.
        far: nothing is seen beyond [m].
        target: what it looks at, in place of `quaternion`, in world or in the link [m]; image up is z there.
        link: the robot's link that carries it; None where it stands in world.
        renderer: SAPIEN's, or triangles drawn on the CPU; `auto` is SAPIEN's where Vulkan works.
        shapes: whether bodies are seen by their visual meshes, where they have some, or as physics knows them.
        noise: what its sensor does to a frame: `realsense`, `kinect2`, or fields of `Noise`; None for nothing.
    """

    name: str = "overhead"
    width: Annotated[int, Field(gt=0)] = 320
    height: Annotated[int, Field(gt=0)] = 240
    field_of_view: Annotated[float, Field(gt=0, lt=np.pi)] = 0.44
    position: Vector = (0.53, 0.14, 1.30)
    quaternion: tuple[Finite, Finite, Finite, Finite] = (0.0, 0.7071067811865476, -0.7071067811865476, 0.0)
    far: Positive = 3.0
    target: Vector | None = None
    link: str | None = None
    renderer: Literal["auto", "sapien", "raster"] = "auto"
    shapes: Literal["visual", "collision"] = "visual"
    noise: Noise | None = None

    def __post_init__(self) -> None:
        if self.target == self.position:
            raise ValueError("a camera can't look at where it is: `target` is its `position`")

    def info(self) -> CameraInfo:
        """Return the camera's geometry; its pose is in world, or in the link that carries it."""
        f = self.height / 2 / np.tan(self.field_of_view / 2)
        matrix = [[f, 0, self.width / 2], [0, f, self.height / 2], [0, 0, 1]]
        return CameraInfo(self.width, self.height, np.array(matrix), self._pose())

    def _pose(self) -> Pose:
        frame = self.link or "world"
        if self.target is None:
            return Pose(self.position, self.quaternion, frame)
        forward = np.subtract(self.target, self.position) / np.linalg.norm(np.subtract(self.target, self.position))
        up = (0.0, 0.0, 1.0) if abs(forward[2]) < 0.999 else (1.0, 0.0, 0.0)  # as the default camera has it
        right = np.cross(forward, up) / np.linalg.norm(np.cross(forward, up))
        matrix = np.eye(4)
        matrix[:3] = np.column_stack([right, np.cross(forward, right), forward, self.position])
        return Pose.from_matrix(matrix, frame)


CRATE = RegionSpec("crate", (0.26, 0.30, 0.14), (0.48, -0.40, 0.07), target=True)


@dataclass(frozen=True, slots=True)
class WorldSpec:
    """Everything that makes a world: the same spec always makes the same world.

    Attributes:
        robot: a ready-made robot's name or a file; see `grip_bt.commanders.description.load.load_robot`.
        floor: height of the floor that is under every world [m]; `fallen` is what lies lower than 5 cm below z = 0,
            or below `fallen_below`.
        dt: time step of the physics [s].
        jerks: joint -> limit with which it is braked [rad/s^3 or m/s^3]; any for a motion of none of these.
        judge: name -> condition over what the referee finds, see `grip_sim.referee`.
        faults: name -> what goes wrong on purpose.
        articulated: name -> a drawer, a button, a bottle with a screw cap, or a pipette; a cabinet is among the boxes.
        shake: what objects have to stay in the hand through; None where nobody asks.
    """

    robot: str = "panda_allegro"
    seed: int = 0
    objects: tuple[ObjectSpec, ...] = ()
    boxes: Boxes = (TABLE, *open_box("crate", (0.26, 0.30, 0.06), (0.48, -0.40, 0.0)))
    meshes: tuple[MeshSpec, ...] = ()
    regions: tuple[RegionSpec, ...] = (CRATE,)
    cameras: tuple[CameraSpec, ...] = (CameraSpec(),)
    floor: Finite = -0.75
    fallen_below: Finite = -0.05
    dt: Positive = 1 / 240
    jerks: Mapping[str, Positive] = field(default_factory=dict)
    judge: Mapping[str, str] = field(default_factory=dict)
    faults: Mapping[str, Fault] = field(default_factory=dict)
    articulated: Mapping[str, ArticulatedConfig] = field(default_factory=dict)
    shake: ShakeConfig | None = None

    @property
    def measures(self) -> tuple[str, ...]:
        """Names of the numbers that the referee has of what has joints, of liquids [ml], and of a shake."""
        own = [measure for name, said in self.articulated.items() for measure in said.measures(name)]
        volumes = [VOLUME.format(each.name) for each in self.objects if each.vessel]
        return (*own, *volumes, *([SPILLED] if volumes else ()), *([MEASURE] if self.shake else ()))

    def to_json(self) -> object:
        """Return the spec as JSON data."""
        return TypeAdapter(WorldSpec).dump_python(self, mode="json")

    @classmethod
    def from_json(cls, data: object) -> WorldSpec:
        """Return the spec that `to_json` wrote."""
        return TypeAdapter(cls).validate_python(data)
