"""Objects by name: files `objects/NAME.yaml` of a project, and the library that is built in (`BUILTIN`).

A file says what an object is made of, or names a mesh with its convex parts; `load_object` makes an `ObjectModel` of
it. Nothing here imports SAPIEN.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.yaml.models import read_model
from grip_bt.commanders.description.file_cache import note

from .model import ObjectFile
from .solids import extent_of

if TYPE_CHECKING:
    from .body import ObjectModel

HERE = Path(__file__).parent / "library"
BUILTIN = tuple(sorted(file.stem for file in HERE.glob("*.yaml")))
FOLDER = "objects"


def files_by_name(builtin: Path, own: Path | None) -> dict[str, Path]:
    """Return the YAML files of two folders by name; those of a project's own come first, and hide others."""
    mine = {file.stem: file for file in sorted(own.glob("*.yaml"))} if own is not None else {}
    return mine | {file.stem: file for file in sorted(builtin.glob("*.yaml")) if file.stem not in mine}


def file_named(kind: str, name: str, files: Mapping[str, Path]) -> Path:
    """Return the file of a name, or the path itself of one that ends in `.yaml`. Raises UnknownNameError."""
    path = Path(name) if name.endswith((".yaml", ".yml")) else files.get(name)
    if path is None:
        raise UnknownNameError(kind, name, files)
    return path


def object_files(project: Path | None = None) -> dict[str, Path]:
    """Return every object's file by name."""
    return files_by_name(HERE, project and project / FOLDER)


def object_file(name: str, project: Path | None = None) -> Path:
    """Return the path of the file of an object of the project or of the library; see `file_named`."""
    return file_named("object", name, object_files(project))


def load_object(path: Path) -> ObjectModel:
    """Return what a file describes. Raises DocumentError where it, or a mesh that it names, is missing or wrong."""
    note(path)
    file = _read(path, _written(path))
    meshes = (_written(path.parent / mesh) for mesh in (file.mesh, file.parts) if mesh)
    return _load(path, _written(path), tuple(meshes))


def measures_of(path: Path) -> tuple[float, float, float, float]:
    """Return radius and height [m], mass [kg] and friction as `load_object` does; of pieces without their hulls."""
    note(path)
    file = _read(path, _written(path))
    if file.solids:
        radius, height = _extent(path, _written(path))
    else:
        model = load_object(path)
        radius, height = model.radius, model.size[2]
    return radius, height, file.mass, file.friction


@lru_cache(maxsize=256)
def _extent(path: Path, written: int) -> tuple[float, float]:
    return extent_of(_read(path, written), path)


@lru_cache(maxsize=256)
def _read(path: Path, written: int) -> ObjectFile:
    return read_model(path, ObjectFile)


@lru_cache(maxsize=256)
def _load(path: Path, written: int, meshes: tuple[int, ...]) -> ObjectModel:
    from .body import build  # which needs trimesh and scipy; worlds of simple shapes start without

    return build(_read(path, written), path)


def _written(path: Path) -> int:
    """Return when a file was written last, by which it is read again."""
    return path.stat().st_mtime_ns if path.is_file() else 0


__all__ = ["BUILTIN", "ObjectFile", "load_object", "measures_of", "object_file", "object_files"]
