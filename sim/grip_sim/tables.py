"""Random worlds: a table with a crate and upright objects, drawn from a seed."""

from __future__ import annotations

from typing import Literal

import numpy as np

from grip_sim.specs import Colour, ObjectSpec, WorldSpec

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
