"""What `objects/NAME.yaml` may hold. Lengths in m, masses in kg, angles in rad; z is up when the object stands."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from grip_bt.base.yaml.models import Finite, NotNegative, Positive, Settings, exactly_one
from grip_sim.articulated.model import Size, Vector
from grip_sim.specs import Colour


def _rising(profile: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    heights = [z for _, z in profile]
    if any(above < below for below, above in zip(heights, heights[1:], strict=False)) or heights[0] == heights[-1]:
        raise ValueError("a profile is a list of [radius, height] from the bottom to the top; heights don't sink")
    return profile


Profile = Annotated[tuple[tuple[NotNegative, Finite], ...], Field(min_length=2, max_length=64), AfterValidator(_rising)]
"""Radius and height of points along an outline, from the bottom to the top."""


class SolidConfig(Settings):
    """One piece of an object: exactly one of `box`, `ball`, `turned`, `bent` and `prism`."""

    box: Size | None = None
    """Edge lengths; its middle is at `at` [m]."""
    ball: Positive | None = None
    """Radius of a ball; its middle is at `at` [m]."""
    turned: Profile | None = None
    """A solid of revolution about z: radius and height of points from the bottom to the top [m]."""
    wall: Positive | None = None
    """Of a turned piece: thickness of its wall and bottom; it is open at the top. Solid without it [m]."""
    bent: Annotated[tuple[Vector, ...], Field(min_length=2, max_length=64)] | None = None
    """Points of the middle line of a rod [m]."""
    radius: Positive | Annotated[tuple[Positive, ...], Field(min_length=2)] | None = None
    """Of a bent rod, everywhere or at each of its points [m]."""
    prism: Annotated[tuple[tuple[Finite, Finite], ...], Field(min_length=3, max_length=64)] | None = None
    """Corners of a convex foot, x and y; it reaches from z = 0 to `height` [m]."""
    height: Positive | None = None
    """Of a prism [m]."""
    at: Vector = (0.0, 0.0, 0.0)
    """Where its origin is, in the object's frame [m]."""
    turn: Vector = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw, before it is put at `at` [rad]."""
    colour: Colour | None = None
    """Red green blue, 0-255; the object's own where not given."""

    @model_validator(mode="after")
    def _one_form(self) -> SolidConfig:
        exactly_one(self, ("box", "ball", "turned", "bent", "prism"))
        if self.bent and self.radius is None:
            raise ValueError("a bent rod needs a `radius`: a number, or one for each point")
        if self.bent and isinstance(self.radius, tuple) and len(self.radius) != len(self.bent):
            raise ValueError(f"it has {len(self.bent)} points, but {len(self.radius)} radii")
        if self.prism and self.height is None:
            raise ValueError("a prism needs a `height`")
        if self.wall and not self.turned:
            raise ValueError("only a turned piece has a `wall`")
        return self


class ObjectFile(Settings):
    """One object: pieces, or a mesh with the convex parts by which it collides."""

    grip: Literal[1]
    doc: str = ""
    solids: tuple[SolidConfig, ...] = ()
    """What it is made of; pieces may touch, and should hardly overlap."""
    mesh: str | None = None
    """Path of what it looks like, beside this file, in place of `solids`."""
    parts: str | None = None
    """Path of an obj file whose objects are the convex parts of the mesh, in its frame; its hull without it."""
    scale: Positive = 1.0
    """Factor of all lengths; 0.001 for a mesh in millimetres."""
    mass: Positive
    """Of the whole [kg]."""
    friction: NotNegative = 0.6
    """Coefficient against hands and fixtures."""
    colour: Colour | None = None
    """Red green blue, 0-255."""
    centre_of_mass: Vector | None = None
    """In the frame of the solids or the mesh, scaled [m]; that of a body of even density without it."""
    source: str = ""
    """Where it comes from, and its licence."""

    @model_validator(mode="after")
    def _one_form(self) -> ObjectFile:
        if bool(self.solids) == (self.mesh is not None):
            raise ValueError("an object has either `solids` or a `mesh`")
        if self.parts and self.mesh is None:
            raise ValueError("`parts` belong to a `mesh`")
        return self
