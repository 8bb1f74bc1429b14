"""The simulated world of a project: its file, what a seed draws, what arms avoid and aim at, and how it is judged.

Conditions of `goals` and `judge` name how many objects are in a state (`held`, `placed` ...), how many there are
(`objects`), how many have their centre in a region (`in_REGION`), and measures, such as `cabinet_opened` [m].
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import get_args

from grip_bt.app.project.folder import Project
from grip_bt.base.errors import DocumentError, EvaluationError, ExpressionError, GripError, nearest
from grip_bt.base.evaluation import condition_of
from grip_bt.base.expression import parse_expression
from grip_bt.base.values import Pose
from grip_bt.base.values.solids import Box
from grip_bt.commanders.description.file_cache import FileCache
from grip_bt.commanders.scene_state import SceneObject
from grip_sim.referee import ObjectTruth, Status
from grip_sim.specs import WorldSpec
from grip_sim.worlds import load_world

_worlds: FileCache[tuple[str, str], WorldSpec | GripError] = FileCache()


def world_of(project: Project, seed: int, world: str = "", object: str = "") -> WorldSpec:
    """Return a world, by default the project's own, with the project's robot, as a seed draws it; see `load_world`."""
    spec = load_world(world or project.file.world or "", seed, project.folder, object=object)
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


STATES: tuple[str, ...] = get_args(Status)
"""What a referee may say of an object."""
Counts = Mapping[str, float]


class WorldCondition:
    """A condition over what is true in a world; `where` and `file` are named in errors, such as `goals/pick`.

    Raises DocumentError where it isn't a condition over the names of its regions and measures.
    """

    def __init__(self, text: str, regions: Iterable[str], measures: Iterable[str], where: str, file: str):
        self.text = text
        known = ("objects", *STATES, *(f"in_{region}" for region in regions), *measures)
        self._counts: Counts = dict.fromkeys(known, 0)
        try:
            parsed = parse_expression(text)
            for name in parsed.names:
                if name not in known:
                    near, there = nearest(name, known), ", ".join(known)
                    raise DocumentError(f"{where}: unknown name {name!r}{near} (available: {there})", file)
            self._compute = condition_of(parsed, {name: partial(self._count, name) for name in parsed.names})
            self._compute()
        except (ExpressionError, EvaluationError) as error:
            raise DocumentError(f"{where}: {error}", file) from error

    def holds(self, counts: Counts) -> bool:
        """Tell whether it is true of what was counted, see `counted`."""
        self._counts = counts
        return self._compute()

    def _count(self, name: str) -> float:
        return self._counts.get(name, 0)


def counted(truth: Iterable[ObjectTruth], regions: Iterable[str], measures: Counts) -> Counts:
    """Return how many objects are in each state and region, how many there are, and the measures."""
    truth = tuple(truth)
    states: Counter[str] = Counter(thing.status for thing in truth)
    inside = Counter(region for thing in truth for region in thing.regions)
    return {
        "objects": len(truth),
        **{state: states[state] for state in STATES},
        **{f"in_{region}": inside[region] for region in regions},
        **measures,
    }
