"""What a world's file says of articulated objects, and which numbers the referee has of them. No SAPIEN here."""

from __future__ import annotations

from collections.abc import Iterator

from pydantic import model_validator

from grip_bt.base.yaml.models import Finite, Positive, Settings, exactly_one

Vector = tuple[Finite, Finite, Finite]
WALL = 0.012
"""Thickness of a cabinet's walls [m]."""
Size = tuple[Positive, Positive, Positive]


class DrawerConfig(Settings):
    """A cabinet that never moves, with a drawer that opens towards its -x by a bar at its front."""

    size: Size = (0.24, 0.3, 0.16)
    """Of the cabinet: depth, width, height [m]."""
    travel: Positive = 0.16
    """How far it opens [m]."""
    mass: Positive = 1.0
    """Of the drawer [kg]."""
    friction: Positive = 3.0
    """Dry friction of its slides [N]."""
    bar: Positive = 0.016
    """Thickness of the bar that it is pulled by [m]."""

    @model_validator(mode="after")
    def _fits(self) -> DrawerConfig:
        if min(self.size) < 0.06 or self.travel >= self.size[0]:
            raise ValueError("a cabinet's edges are at least 0.06 m long, and its drawer opens by less than its depth")
        return self

    def cabinet(self) -> Iterator[tuple[str, Size, Vector]]:
        """Yield the cabinet's walls, open towards -x: name, edges, and middle from its underside's [m]."""
        depth, width, height = self.size
        inside = height - 2 * WALL
        yield "bottom", (depth, width, WALL), (0.0, 0.0, WALL / 2)
        yield "top", (depth, width, WALL), (0.0, 0.0, height - WALL / 2)
        yield "left", (depth, WALL, inside), (0.0, (width - WALL) / 2, height / 2)
        yield "right", (depth, WALL, inside), (0.0, (WALL - width) / 2, height / 2)
        yield "back", (WALL, width - 2 * WALL, inside), ((depth - WALL) / 2, 0.0, height / 2)


class ButtonConfig(Settings):
    """A push button on a box, pressed from above, which clicks."""

    radius: Positive = 0.02
    """Of its key [m]."""
    force: Positive = 1.4
    """At which it clicks [N]."""
    travel: Positive = 0.004
    """Of its key [m]; it clicks at two fifths, is pressed below two thirds, and released above a third."""


class ScrewBottleConfig(Settings):
    """A bottle that stands freely, with a cap on a thread, which comes off."""

    radius: Positive = 0.03
    """Of the bottle [m]."""
    height: Positive = 0.12
    """Of the bottle without its cap [m]."""
    mass: Positive = 0.3
    """Of the bottle [kg]."""
    cap_radius: Positive = 0.018
    """Of the cap [m]."""
    cap_height: Positive = 0.02
    """Of the cap [m]."""
    cap_mass: Positive = 0.02
    """Of the cap [kg]."""
    pitch: Positive = 0.003
    """By which a turn lifts the cap [m]."""
    turns: Positive = 1.0
    """Until the thread lets go."""
    friction: Positive = 0.05
    """Dry friction of the thread [N m]."""
    held: bool = False
    """Whether the bottle is fixed where it stands."""


class PipetteConfig(Settings):
    """A pipette that stands freely, tip down: a handle with a collar, which lies on a finger, and a sprung plunger."""

    volume: Positive = 5.0
    """What the plunger's whole way draws [ml]."""
    travel: Positive = 0.012
    """Of the plunger [m]."""
    force: Positive = 4.0
    """By which the spring presses back at the end of that; two fifths of it at rest [N]."""
    radius: Positive = 0.02
    """Of the handle [m]."""
    handle: Positive = 0.1
    """Length of the handle, up to its collar [m]."""
    neck: Positive = 0.032
    """Length of what is above the collar and below the plunger [m]."""
    shaft: Positive = 0.14
    """From the tip to the handle [m]."""
    mass: Positive = 0.12
    """Without the plunger [kg]."""


MEASURES = {
    "drawer": ("opened",),
    "button": ("presses",),
    "screw_bottle": ("turns", "off", "slid", "twisted", "rise"),
    "pipette": ("pressed", "holds"),
}
"""The forms of articulated objects, and which numbers the referee has of each."""


class ArticulatedConfig(Settings):
    """An articulated object and where it stands."""

    drawer: DrawerConfig | None = None
    button: ButtonConfig | None = None
    screw_bottle: ScrewBottleConfig | None = None
    pipette: PipetteConfig | None = None
    at: Vector
    """The middle of its underside [m]."""
    yaw: Finite = 0.0
    """Turn about the vertical [rad]."""

    @model_validator(mode="after")
    def _one_form(self) -> ArticulatedConfig:
        exactly_one(self, tuple(MEASURES))
        return self

    @property
    def kind(self) -> str:
        """What it is: the key of its form."""
        return next(kind for kind in MEASURES if getattr(self, kind) is not None)

    def measures(self, name: str) -> tuple[str, ...]:
        """Return the names of the numbers that the referee has of it."""
        return tuple(f"{name}_{each}" for each in MEASURES[self.kind])
