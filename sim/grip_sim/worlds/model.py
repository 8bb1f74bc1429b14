"""What `worlds/NAME.yaml` may hold. Things stand at `at`: the middle of their underside, in the robot's base frame."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, StringConstraints, model_validator

from grip_bt.base.yaml.models import Finite, NotNegative, Positive, Settings, exactly_one
from grip_bt.commanders.description.config import RobotConfig
from grip_sim.articulated.model import ArticulatedConfig, Size, Vector
from grip_sim.faults import Fault, rising
from grip_sim.liquids import VesselConfig
from grip_sim.noise import Noise
from grip_sim.shaking import ShakeConfig
from grip_sim.specs import Colour

Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")]


Span = Positive | Annotated[tuple[Positive, Positive], AfterValidator(rising)]
"""A number, or from and to, which a seed draws between."""


class FixtureConfig(Settings):
    """Something that never moves: a box, an open box (four walls), or a mesh."""

    box: Size | None = None
    """Edge lengths [m]."""
    open_box: Size | None = None
    """Inner size in x and y, height of the walls [m]; its walls are `NAME_left`, `_right`, `_far` and `_near`."""
    wall: Positive = 0.01
    """Thickness of an open box's walls [m]."""
    mesh: str | None = None
    """Path of an obj, stl, ply or dae file, beside this one; its origin is put at `at`."""
    scale: Positive = 1.0
    """Factor of the mesh's lengths; 0.001 for one in millimetres."""
    at: Vector = (0.0, 0.0, 0.0)
    """The middle of its underside; of a mesh, its origin [m]."""
    yaw: Finite = 0.0
    """Turn about the vertical [rad]."""
    pitch: Finite = 0.0
    """Slope of a box, which falls towards its +x [rad]."""
    colour: Colour | None = None
    """Red green blue, 0-255."""

    @model_validator(mode="after")
    def _one_form(self) -> FixtureConfig:
        exactly_one(self, ("box", "open_box", "mesh"))
        if self.pitch and not self.box:
            raise ValueError("only a box has a `pitch`")
        if self.open_box and self.yaw:
            raise ValueError("an open box can't be turned: build it of four boxes")
        return self


class RegionConfig(Settings):
    """An upright box of space that tasks aim at and the referee judges by."""

    size: Size
    """Edge lengths [m]."""
    at: Vector
    """The middle of its underside [m]."""
    yaw: Finite = 0.0
    """Turn about the vertical [rad]."""
    target: bool = False
    """Whether an object at rest in it counts as placed."""


class ShapeConfig(Settings):
    """An object of a simple shape, or a model; where numbers are ranges, the seed draws."""

    shape: Literal["cylinder", "box", "sphere"] | None = None
    """A box has a square foot."""
    model: str | None = None
    """An object of the project's or the library, or the path of a file that describes one; in place of `shape`."""
    scale: Span = 1.0
    """Factor of a model's lengths."""
    radius: Span | None = None
    """Of a cylinder or sphere; half the edge of a box's foot [m]."""
    height: Span | None = None
    """Of a cylinder or box [m]."""
    mass: Span | None = None
    """Without it a model has its own, other shapes 0.2 [kg]."""
    friction: NotNegative | None = None
    """Coefficient against hands and fixtures; a model's own, and 1 of other shapes, without it."""
    colour: Colour | None = None
    """Red green blue, 0-255; of a shape."""
    vessel: VesselConfig | None = None
    """Its inside, where liquids may be in it."""

    @model_validator(mode="after")
    def _one_form(self) -> ShapeConfig:
        if self.shape and self.model:
            raise ValueError("an object has either a `shape` or a `model`")
        if not (self.shape or self.model or isinstance(self, ObjectConfig) and self.draw):
            raise ValueError("an object needs a `shape`, cylinder, box or sphere, or a `model`, such as mug")
        if self.shape and not self.radius:
            raise ValueError(f"a {self.shape} needs a `radius` [m]")
        if self.shape in ("cylinder", "box") and not self.height:
            raise ValueError(f"a {self.shape} needs a `height` [m]")
        return self


class ObjectConfig(ShapeConfig):
    """An object at a place, or several that a seed draws into a region."""

    at: Vector | None = None
    """Where it stands; the middle of its underside [m]."""
    yaw: Finite = 0.0
    """Turn about the vertical [rad]."""
    tilt: tuple[Finite, Finite] = (0.0, 0.0)
    """Roll and pitch [rad]."""
    draw: Annotated[int, Field(ge=0)] = 0
    """How many are drawn."""
    of: tuple[ShapeConfig, ...] = ()
    """What is drawn from; each is as likely as another."""
    region: Name | None = Field(default=None, alias="in")
    """The region that they are drawn into."""
    clearance: Positive | None = None
    """Least distance between the middles of two drawn objects [m]; by default the size of the largest."""
    drop: bool = False
    """Whether they fall into the region, turned at random, one above the other, instead of standing in it."""

    @model_validator(mode="after")
    def _place(self) -> ObjectConfig:
        if self.draw and (self.shape or self.model or self.at):
            raise ValueError("drawn objects take `of` and `in`, not `shape`, `model` or `at`")
        if self.draw and not (self.of and self.region):
            raise ValueError("drawn objects need `of: [{shape: ...}, {model: ...}, ...]` and `in: REGION`")
        if not self.draw and self.at is None:
            raise ValueError("an object needs a place: `at: [x, y, z]`, the middle of its underside")
        return self


class CameraConfig(Settings):
    """A pinhole RGB-D camera."""

    at: Vector
    """The optical centre; in the link's frame where there is a `link` [m]."""
    look_at: Vector | None = None
    """The point in the middle of the image; the image's up is z [m]."""
    quaternion: tuple[Finite, Finite, Finite, Finite] | None = None
    """Of the optical frame (x right, y down, z forward), w x y z; instead of `look_at`."""
    width: Annotated[int, Field(gt=0, le=4096)] = 320
    """Of the image [px]."""
    height: Annotated[int, Field(gt=0, le=4096)] = 240
    """Of the image [px]."""
    field_of_view: Annotated[float, Field(gt=0, lt=3.14)] = 0.8
    """Vertical opening angle [rad]."""
    far: Positive = 3.0
    """Nothing is seen beyond [m]."""
    link: str | None = None
    """The robot's link that carries it; without it, it stands in the world."""
    renderer: Literal["auto", "sapien", "raster"] = "auto"
    """`sapien` draws by Vulkan, `raster` triangles on the CPU; `auto` takes `sapien` where Vulkan works."""
    noise: Noise | None = None
    """What its sensor does to a frame: `realsense`, `kinect2`, or its figures; nothing without it."""

    @model_validator(mode="after")
    def _one_direction(self) -> CameraConfig:
        exactly_one(self, ("look_at", "quaternion"))
        if self.look_at == self.at:
            raise ValueError("the camera can't look at where it is")
        return self


class WorldFile(Settings):
    """One world."""

    grip: Literal[1]
    doc: str = ""
    robot: str | RobotConfig | None = None
    """The robot where a project names none; as `robot:` in grip.yaml, with several robots where they stand."""
    fixtures: dict[Name, FixtureConfig] = {}
    regions: dict[Name, RegionConfig] = {}
    objects: dict[Name, ObjectConfig] = {}
    articulated: dict[Name, ArticulatedConfig] = {}
    """What has joints of its own: drawers, buttons, bottles with a screw cap, pipettes."""
    cameras: dict[Name, CameraConfig] = {}
    judge: dict[Name, str] = {}
    """Name -> condition over what the referee finds in the end, such as `placed == objects`; see docs/worlds.md."""
    shake: ShakeConfig | None = None
    """A shake of the hand that `judge` knows of, as `held_through_shake`; `{}` for the usual one."""
    faults: dict[Name, Fault] = {}
    """What goes wrong on purpose; see docs/worlds.md."""
    floor: Annotated[float, Field(le=0, allow_inf_nan=False)] = -0.75
    """Height of the floor [m]."""
    fallen_below: Finite = -0.05
    """An object whose centre is lower has fallen [m]."""
    dt: Annotated[float, Field(gt=0, le=0.01)] = 1 / 240
    """Time step of the physics [s]; a smaller one shows whether results depend on it."""

    @model_validator(mode="after")
    def _known_regions(self) -> WorldFile:
        for name, thing in self.objects.items():
            if thing.region is not None and thing.region not in self.regions:
                known = ", ".join(self.regions) or "none"
                raise ValueError(f"objects/{name}/in: there is no region {thing.region!r} (available: {known})")
        return self
