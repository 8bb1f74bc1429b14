"""The simulated world of a project: its file, what a seed draws, and what of it arms avoid and aim at."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

from grip_bt.base.errors import GripError
from grip_bt.base.values import Pose
from grip_bt.base.values.solids import Box
from grip_bt.commanders.description.files import FileCache
from grip_bt.commanders.scene_state import SceneObject
from grip_sim.specs import WorldSpec
from grip_sim.worlds import load_world

from .folder import Project
from .judging import WorldCondition

_worlds: FileCache[tuple[str, str], WorldSpec | GripError] = FileCache()


def world_of(project: Project, seed: int, world: str = "") -> WorldSpec:
    """Return a world with the project's robot in it, as a seed draws it.

    Args:
        project: the project.
        seed: of what is drawn.
        world: its name; the project's own where empty.

    Raises:
        UnknownNameError, DocumentError: there is no such world, or its file is wrong.
        ArrangementError: objects don't fit into it.
    """
    spec = load_world(world or project.file.world or "", seed, project.folder)
    return replace(spec, robot=project.robot_source)


def checked_world(project: Project, world: str) -> WorldSpec | GripError:
    """Return a world as seed 0 draws it, or what is wrong with it; its files are read again when they change."""
    return _worlds.get((str(project.folder), world), partial(_read, project, world))


def _read(project: Project, world: str) -> WorldSpec | GripError:
    try:
        spec = load_world(world, 0, project.folder)
        for name, text in spec.judge.items():
            WorldCondition(text, [r.name for r in spec.regions], spec.measures, f"judge/{name}", f"world {world}")
        return spec
    except GripError as error:
        return error


def room_of(spec: WorldSpec) -> tuple[SceneObject, ...]:
    """Return what never moves, which arms avoid."""
    from grip_bt.commanders.kinematics.shapes import load_mesh

    boxes = (SceneObject(box.name, Box(box.size), box.pose, fixed=True) for box in spec.boxes)
    meshes = (
        SceneObject(each.name, load_mesh(each.file, (each.scale,) * 3, hollow=True), each.pose, fixed=True)
        for each in spec.meshes
    )
    return (*boxes, *meshes)


def regions_of(spec: WorldSpec) -> Mapping[str, tuple[Sequence[float], Pose]]:
    """Return the places that tasks aim at: edge lengths [m] and the middle in world, by name."""
    return {region.name: (region.size, region.pose) for region in spec.regions}
