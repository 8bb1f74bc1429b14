"""Worlds by name: files `worlds/NAME.yaml` of a project, and those that are built in (`BUILTIN`).

A file says what there is, in which regions a seed draws objects, and what the referee judges; `arrange` makes a
`WorldSpec` of it, and `grip_sim.world` its physics. Nothing here imports SAPIEN.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

import numpy as np

from grip_bt.base.errors import GripError
from grip_bt.base.values import Pose
from grip_bt.base.values.pose import angles_of
from grip_bt.base.yaml.models import read_model
from grip_bt.commanders.description.file_cache import note
from grip_sim.articulated.model import ArticulatedConfig
from grip_sim.objects import file_named, files_by_name, measures_of, object_file
from grip_sim.specs import BoxSpec, CameraSpec, Colour, MeshSpec, ObjectSpec, RegionSpec, WorldSpec, open_box, upright

from .model import CameraConfig, FixtureConfig, ObjectConfig, ShapeConfig, Span, WorldFile

HERE = Path(__file__).parent
BUILTIN = tuple(sorted(file.stem for file in HERE.glob("*.yaml")))
FOLDER = "worlds"


def world_files(project: Path | None = None) -> dict[str, Path]:
    """Return every world's file by name."""
    return files_by_name(HERE, project and project / FOLDER)


def read_world(name: str, project: Path | None = None) -> tuple[WorldFile, Path]:
    """Return a world's file, read, and its path.

    Args:
        name: of a built-in world or one of the project's, or a path that ends in `.yaml`.

    Raises:
        UnknownNameError: there is no such world.
        DocumentError: the file is wrong; with line and column.
    """
    path = file_named("world", name, world_files(project))
    note(path)
    return read_model(path, WorldFile), path


def load_world(name: str, seed: int = 0, project: Path | None = None, robot: str = "", object: str = "") -> WorldSpec:
    """Return a world with what a seed draws, see `arrange`; with `object`, its objects are such ones instead.

    Raises:
        UnknownNameError, DocumentError: see `read_world`.
        ArrangementError: drawn objects don't fit.
    """
    world, path = read_world(name, project)
    if object:
        world = world.model_copy(update={"objects": {n: _other(thing, object) for n, thing in world.objects.items()}})
    own = "" if world.robot is None else world.robot if isinstance(world.robot, str) else str(path)
    home = project or path.parent.parent
    return arrange(world, seed, path.parent, robot or own, lambda each: object_file(each, home))


def object_at(name: str, model: str, pose: Pose, project: Path | None = None) -> ObjectSpec:
    """Return an object whose centre is at a pose in world; `model` names one, or its file.

    Raises UnknownNameError, DocumentError: there is no such object, or its file is wrong.
    """
    made = _made(ShapeConfig(model=model), None, lambda each: object_file(each, project))
    x, y, z = pose.position.tolist()
    roll, pitch, yaw = angles_of(pose.rotation())
    return replace(made, name=name, position=(x, y, z), yaw=yaw, tilt=(roll, pitch), colour=COLOURS[0])


def _other(thing: ObjectConfig, model: str) -> ObjectConfig:
    if thing.draw:
        return thing.model_copy(update={"of": (ShapeConfig(model=model),)})
    return ObjectConfig(model=model, at=thing.at, yaw=thing.yaw, tilt=thing.tilt)


TRIES, RESTARTS = 10_000, 30
COLOURS: tuple[Colour, ...] = ((205, 60, 45), (60, 150, 70), (225, 170, 40), (120, 70, 160), (30, 140, 160))
ORIGIN = (0.0, 0.0, 0.0)
GREY: Colour = (150, 150, 150)
WOOD: Colour = (150, 112, 74)
Place: TypeAlias = tuple[float, float]
Models: TypeAlias = Callable[[str], Path]
"""Returns the file of an object that is named."""


class ArrangementError(GripError):
    """Objects don't fit where they are to be drawn."""


def arrange(world: WorldFile, seed: int, folder: Path, robot: str = "", models: Models = object_file) -> WorldSpec:
    """Return the arrangement that a seed draws: the same file and seed give the same one.

    Raises:
        UnknownNameError, DocumentError: there is no such object, or its file is wrong.
        ArrangementError: drawn objects don't fit; it says how many do.
    """
    rng = np.random.default_rng(seed)
    regions = tuple(
        RegionSpec(name, r.size, (r.at[0], r.at[1], r.at[2] + r.size[2] / 2), r.yaw, r.target)
        for name, r in world.regions.items()
    )
    fixed = [_placed(name, thing, models) for name, thing in world.objects.items() if not thing.draw]
    taken = [thing.position[:2] for thing in fixed]
    objects = list(fixed)
    for name, thing in world.objects.items():
        if thing.draw:
            region = next(region for region in regions if region.name == thing.region)
            objects += _drawn(name, thing, region, taken, rng, models)
    return WorldSpec(
        robot=robot or "panda_allegro",
        seed=seed,
        objects=tuple(objects),
        boxes=tuple(
            [box for name, fixture in world.fixtures.items() for box in _boxes(name, fixture)]
            + [box for name, said in world.articulated.items() for box in _cabinets(name, said)]
        ),
        meshes=tuple(
            MeshSpec(name, str(folder / each.mesh), each.at, each.yaw, each.scale, each.colour or GREY)
            for name, each in world.fixtures.items()
            if each.mesh is not None
        ),
        regions=regions,
        cameras=tuple(camera_of(name, camera) for name, camera in world.cameras.items()),
        floor=world.floor,
        fallen_below=world.fallen_below,
        dt=world.dt,
        judge=world.judge,
        faults=world.faults,
        articulated=world.articulated,
        shake=world.shake,
    )


def _boxes(name: str, fixture: FixtureConfig) -> Iterator[BoxSpec]:
    x, y, z = fixture.at
    if fixture.box is not None:
        centre, colour = (x, y, z + fixture.box[2] / 2), fixture.colour or GREY
        yield BoxSpec(name, fixture.box, centre, colour, fixture.yaw, fixture.pitch)
    elif fixture.open_box is not None:
        yield from open_box(name, fixture.open_box, fixture.at, fixture.wall, fixture.colour or (70, 110, 170))


def _cabinets(name: str, said: ArticulatedConfig) -> Iterator[BoxSpec]:
    if said.drawer is not None:
        for wall, size, at in said.drawer.cabinet():
            x, y, z = (float(number) for number in upright(said.at, said.yaw).apply([at])[0])
            yield BoxSpec(f"{name}_{wall}", size, (x, y, z), WOOD, said.yaw)


def _within(rng: np.random.Generator | None, span: Span) -> float:
    if not isinstance(span, tuple):
        return span
    return float(rng.uniform(*span)) if rng is not None else (span[0] + span[1]) / 2


def _made(config: ShapeConfig, rng: np.random.Generator | None, models: Models) -> ObjectSpec:
    """Return what a configuration stands for, at the origin; where nothing is drawn, the middle of ranges and no turn.

    Drawn: radius and height or scale, yaw, mass, in that order, which seeds that people have noted depend on.
    """
    if config.model is not None:
        path = models(config.model)
        (radius, height, mass, friction), scale = measures_of(path), _within(rng, config.scale)
        made = ObjectSpec(path.stem, "model", radius * scale, height * scale, ORIGIN, model=str(path), scale=scale)
        made = replace(made, mass=mass, friction=friction)
    else:
        assert config.shape is not None, "the file was checked"
        assert config.radius is not None, "the file was checked"
        radius = _within(rng, config.radius)
        height = _within(rng, config.height) if config.height is not None else 2 * radius
        made = ObjectSpec(config.shape, config.shape, radius, height, ORIGIN)
    yaw = float(rng.uniform(-np.pi, np.pi)) if rng is not None else 0.0
    mass = made.mass if config.mass is None else _within(rng, config.mass)
    friction = made.friction if config.friction is None else config.friction
    return replace(made, yaw=yaw, mass=mass, friction=friction, vessel=config.vessel)


def _standing(thing: ObjectSpec, x: float, y: float, z: float) -> ObjectSpec:
    """Return it with its underside's middle at a place in world [m]."""
    return replace(thing, position=(float(x), float(y), float(z) + thing.height / 2))


def _placed(name: str, thing: ObjectConfig, models: Models) -> ObjectSpec:
    assert thing.at is not None, "the file was checked"
    made = replace(_made(thing, None, models), name=name, yaw=thing.yaw, tilt=thing.tilt)
    return _standing(replace(made, colour=thing.colour or COLOURS[0]), *thing.at)


def _drawn(
    name: str, thing: ObjectConfig, region: RegionSpec, taken: list[Place], rng: np.random.Generator, models: Models
) -> Iterator[ObjectSpec]:
    clearance = thing.clearance or 0.01 + 2 * max(_made(each, None, models).radius for each in thing.of)
    places = _places(name, thing, clearance, region, taken, rng)
    floor = region.centre[2] - region.size[2] / 2
    for index, place in enumerate(places):
        config = thing.of[min(int(rng.random() * len(thing.of)), len(thing.of) - 1)]
        made, tilt, up = _made(config, rng, models), (0.0, 0.0), floor
        if thing.drop:
            tilt = (float(rng.uniform(-np.pi, np.pi)), float(rng.uniform(-np.pi / 2, np.pi / 2)))
            up += index * clearance + (np.hypot(2 * made.radius, made.height) - made.height) / 2
        colour = config.colour or COLOURS[index % len(COLOURS)]
        yield _standing(replace(made, name=f"{made.name}_{index}", colour=colour, tilt=tilt), place[0], place[1], up)


def _places(
    name: str, thing: ObjectConfig, clearance: float, region: RegionSpec, taken: list[Place], rng: np.random.Generator
) -> list[Place]:
    """Return places in a region, seen from above, that keep their distance; what was tried in vain begins anew."""
    (length, width, _), most = region.size, 0
    (left, front, _), cosine, sine = region.centre, float(np.cos(region.yaw)), float(np.sin(region.yaw))
    for _ in range(1 if thing.drop else RESTARTS):
        places: list[Place] = []
        for _ in range(TRIES):
            if len(places) == thing.draw:
                taken += places
                return places
            x, y = length * rng.random() - length / 2, width * rng.random() - width / 2
            place = (cosine * x - sine * y + left, sine * x + cosine * y + front)
            if thing.drop or all(math.dist(place, other) >= clearance for other in (*taken, *places)):
                places.append(place)
        most = max(most, len(places))
    where = f"the region {region.name!r} ({' x '.join(f'{edge:g}' for edge in region.size[:2])} m)"
    beside = f", beside {len(taken)} others" if taken else ""
    raise ArrangementError(
        f"objects/{name}: {thing.draw} objects {clearance:g} m apart don't fit into {where}"
        f"{beside}: {most} do. Draw fewer, lower `clearance`, enlarge the region, or let them fall: `drop: true`"
    )


def camera_of(name: str, camera: CameraConfig) -> CameraSpec:
    """Return a camera as it is given: by what it looks at, or by its orientation."""
    given = camera.model_dump(exclude={"at", "look_at", "quaternion", "noise"})
    spec = CameraSpec(name, position=camera.at, target=camera.look_at, noise=camera.noise, **given)
    return spec if camera.quaternion is None else replace(spec, quaternion=camera.quaternion)


__all__ = ["BUILTIN", "ArrangementError", "WorldFile", "arrange", "load_world", "read_world", "world_files"]
