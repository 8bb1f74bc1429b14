"""Worlds by name: files `worlds/NAME.yaml` of a project, and those that are built in (`BUILTIN`).

A file says what there is, in which regions a seed draws objects, and what the referee judges; `arrange` makes a
`WorldSpec` of it, and `grip_sim.world` its physics. Nothing here imports SAPIEN.
"""

from __future__ import annotations

from pathlib import Path

from grip_bt.base.yaml.models import read_model
from grip_bt.commanders.description.files import note
from grip_sim.objects import file_named, files_by_name, object_file
from grip_sim.specs import WorldSpec

from .arrange import ArrangementError, arrange
from .model import WorldFile

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


def load_world(name: str, seed: int = 0, project: Path | None = None, robot: str = "") -> WorldSpec:
    """Return a world with what a seed draws; see `arrange`.

    Raises:
        UnknownNameError, DocumentError: see `read_world`.
        ArrangementError: drawn objects don't fit.
    """
    world, path = read_world(name, project)
    own = "" if world.robot is None else world.robot if isinstance(world.robot, str) else str(path)
    home = project or path.parent.parent
    return arrange(world, seed, path.parent, robot or own, lambda each: object_file(each, home))


__all__ = ["BUILTIN", "ArrangementError", "WorldFile", "arrange", "load_world", "read_world", "world_files"]
