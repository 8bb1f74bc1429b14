"""Reading meshes with the colours and pictures that they carry, by trimesh."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.visual import ColorVisuals, TextureVisuals

from grip_bt.base.arrays import Array
from grip_bt.base.errors import DocumentError
from grip_sim.specs import Colour

FORMATS = (".dae", ".glb", ".gltf", ".obj", ".off", ".ply", ".stl")


@dataclass(frozen=True, eq=False)
class Look:
    """Triangles of one colour or one picture.

    Attributes:
        points: shape (n, 3) [m].
        triangles: of these, shape (m, 3), counter-clockwise seen from outside.
        colour: red green blue, 0-255; None for that of the body.
        uv: where each corner is in the picture, shape (m, 3, 2), v upwards; None without one.
        texture: the picture, shape (h, w, 3) uint8, red green blue.
    """

    points: Array
    triangles: NDArray[np.int32]
    colour: Colour | None = None
    uv: Array | None = None
    texture: NDArray[np.uint8] | None = None

    def moved(self, matrix: Array, scale: Array | float = 1.0) -> Look:
        """Return it scaled along its axes and then moved; a mirrored one is turned right side out."""
        points = self.points * scale @ matrix[:3, :3].T + matrix[:3, 3]
        if np.prod(np.broadcast_to(scale, 3)) * np.linalg.det(matrix[:3, :3]) > 0:
            return replace(self, points=points)
        uv = None if self.uv is None else self.uv[:, ::-1]
        return replace(self, points=points, triangles=self.triangles[:, ::-1], uv=uv)


def read_texture(file: Path) -> NDArray[np.uint8] | None:
    """Return a picture, shape (h, w, 3), red green blue; None where there is none."""
    import cv2

    found = cv2.imread(str(file), cv2.IMREAD_COLOR) if file.is_file() else None
    return None if found is None else np.ascontiguousarray(found[:, :, ::-1], np.uint8)


def read_mesh(file: Path) -> tuple[Look, ...]:
    """Return the parts of a mesh file, one for each object, material and place of use; lengths as the file has them.

    Raises DocumentError where it isn't there, or no mesh.
    """
    if file.suffix.lower() not in FORMATS:
        raise DocumentError(f"a mesh is a file of one of the formats {', '.join(f[1:] for f in FORMATS)}", str(file))
    if not file.is_file():
        raise DocumentError("there is no such mesh file", str(file))
    return _read(file, file.stat().st_mtime_ns)


@lru_cache(maxsize=256)
def _read(file: Path, written: int) -> tuple[Look, ...]:
    try:
        own = {"split_objects": True} if file.suffix.lower() == ".obj" else {}
        with warnings.catch_warnings():  # about corners that have no place in a picture
            warnings.simplefilter("ignore", RuntimeWarning)
            scene = trimesh.load_scene(file, process=False, **own)
        parts = tuple(_look(mesh) for mesh in scene.dump() if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces))
    except Exception as error:  # noqa: BLE001 - what trimesh's readers raise isn't told
        raise DocumentError(f"it can't be read as a mesh: {error}", str(file)) from None
    if not parts:
        raise DocumentError("it holds no triangles", str(file))
    return parts


def joined(looks: Iterable[Look]) -> trimesh.Trimesh:
    """Return triangles as one surface, whose corners are shared where they agree."""
    whole = trimesh.util.concatenate([trimesh.Trimesh(look.points, look.triangles) for look in looks])
    whole.merge_vertices(merge_tex=True, merge_norm=True)
    return whole


def _look(mesh: trimesh.Trimesh) -> Look:
    colour, uv, texture = None, None, None
    match mesh.visual:
        case TextureVisuals(material=material, uv=places):
            simple = material.to_simple() if hasattr(material, "to_simple") else material
            if getattr(simple, "image", None) is not None and places is not None and len(places):
                texture = np.ascontiguousarray(np.asarray(simple.image.convert("RGB")), np.uint8)
                uv = np.asarray(places, float)[mesh.faces]
            elif simple.diffuse is not None:
                colour = _colour(simple.diffuse)
        case ColorVisuals(defined=True) as colours:
            colour = _colour(np.median(colours.face_colors, axis=0))
    mesh.merge_vertices(merge_tex=True, merge_norm=True)  # files may have each triangle's corners for itself
    return Look(np.array(mesh.vertices, float), np.array(mesh.faces, np.int32), colour, uv, texture)


def _colour(rgba: NDArray[np.float64]) -> Colour:
    r, g, b = (int(each) for each in np.asarray(rgba)[:3])
    return r, g, b
