"""SAPIEN's renderer by Vulkan, in a scene of its own that has no physics: the same triangles as `RasterRenderer` draws.

What it shows of depth and normals is of its own float32 buffers. Its shaders are SAPIEN's `default` ones, without the
table for reflections of surroundings, which there are none of and which takes seconds to compute on a CPU.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grip_bt.base.errors import GripError
from grip_bt.base.files import copy_folder
from grip_bt.base.values import CameraInfo, Pose
from grip_sim.cameras import AMBIENT, BACKGROUND, DIFFUSE, LIGHT, NEAR, NOTHING, Frame, Places
from grip_sim.cameras.looks import Target
from grip_sim.cameras.mesh_files import Look
from grip_sim.physics import sapien

_TABLE = "vec2 envBRDF = texture(samplerBRDFLUT, vec2(roughness, dotNV)).xy;"
_UNIFORM = "layout(set = SET_NUM, binding = 8) uniform sampler2D samplerBRDFLUT;"
_FLIP = np.array([1.0, -1.0, -1.0])
"""Its pictures are in OpenGL's camera frame: x right, y up, z back."""
_TO_SAPIEN = Pose([0, 0, 0], [0.5, 0.5, -0.5, 0.5])
"""SAPIEN's cameras look along x, z up, in the optical frame."""


@lru_cache(maxsize=1)
def _system() -> Any:
    """Return the process's one render system, kept alive: a new one would set everything up again."""
    try:
        system = sapien.render.RenderSystem()
    except RuntimeError as error:
        message = f"SAPIEN's renderer doesn't work here ({error}); a camera with `renderer: raster` needs no Vulkan"
        raise GripError(message) from None
    sapien.render.set_camera_shader_dir(str(_shaders() / "default"))
    return system


def _shaders() -> Path:
    """Return a folder with SAPIEN's shaders as they are used here; made once for each version of SAPIEN."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "grip"
    folder = cache / f"sapien_shaders_{version('sapien')}"
    if folder.is_dir():
        return folder
    cache.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=cache) as made:
        for name in ("common", "default"):
            copy_folder(Path(sapien.__file__).parent / "vulkan_shader" / name, Path(made, "new", name))
        for file in Path(made, "new", "default").iterdir():
            text = file.read_text()
            file.write_text(text.replace(_TABLE, "vec2 envBRDF = vec2(0.5, 0.1);").replace(_UNIFORM, ""))
        with suppress(OSError):  # somebody else was faster
            Path(made, "new").rename(folder)
    return folder


class SapienRenderer:
    """Draws bodies by their triangles; as `RasterRenderer`. Raises GripError where Vulkan doesn't work here."""

    def __init__(self, info: CameraInfo, far: float, targets: Sequence[Target], visual: bool = True):
        _system()
        self._names, self._far = tuple(target.name for target in targets), far
        self._scene = sapien.Scene([sapien.physx.PhysxCpuSystem(), sapien.render.RenderSystem()])
        self._scene.set_ambient_light([AMBIENT] * 3)
        self._scene.add_directional_light((-LIGHT).tolist(), [np.pi * DIFFUSE] * 3)
        self._entities = [self._add(target, visual) for target in targets]
        field = float(2 * np.arctan(info.height / 2 / info.matrix[1, 1]))
        self._camera = self._scene.add_camera("camera", info.width, info.height, field, NEAR, far)
        self._index = np.full(max((e.per_scene_id for e in self._entities), default=0) + 2, NOTHING, np.int16)
        for label, entity in enumerate(self._entities):
            self._index[entity.per_scene_id] = label

    def draw(self, pose: Pose, places: Places) -> Frame:
        """Return what is seen from a pose of bodies at places; see `Renderer`."""
        for entity, rotation, position in zip(self._entities, *places, strict=True):
            matrix = np.eye(4)
            matrix[:3, :3], matrix[:3, 3] = rotation, position
            entity.set_pose(sapien.Pose(matrix))
        at = pose @ _TO_SAPIEN
        self._camera.entity.set_pose(sapien.Pose(at.position, at.quaternion))
        self._scene.update_render()
        self._camera.take_picture()
        where, colour = self._picture("Position"), self._picture("Color")
        marks = self._picture("Segmentation")[:, :, 1].astype(np.int64)
        seen = (where[:, :, 2] < 0) & (where[:, :, 2] > -self._far)
        labels = np.where(seen, self._index[np.minimum(marks, len(self._index) - 1)], NOTHING).astype(np.int16)
        image = np.round(255 * np.clip(colour[:, :, :3], 0, 1)).astype(np.uint8)
        image[~seen] = BACKGROUND
        depth = np.where(seen, -where[:, :, 2], 0).astype(np.float32)
        normals = np.where(seen[:, :, None], self._picture("Normal")[:, :, :3] * _FLIP, 0).astype(np.float32)
        return Frame(image, depth, labels, self._names, normals, pose)

    def _picture(self, name: str) -> NDArray[Any]:
        return np.asarray(self._camera.get_picture(name))

    def _add(self, target: Target, visual: bool) -> Any:
        entity, body = sapien.Entity(), sapien.render.RenderBodyComponent()
        for look in target.looks(visual):
            if look.triangles.size:
                body.attach(_shape(look, target))
        entity.add_component(body)
        entity.name = target.name
        self._scene.add_entity(entity)
        return entity


def _shape(look: Look, target: Target) -> Any:
    """Return a mesh whose triangles share no corners, so that each has its own normal."""
    corners = look.points[look.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    colour = np.array(look.colour or target.colour) / 255
    material = sapien.render.RenderMaterial()
    material.base_color = [*(colour**2.2).tolist(), 1.0]
    material.roughness, material.specular, material.metallic = 1.0, 0.0, 0.0
    uv = np.zeros((len(corners) * 3, 2), np.float32)
    if look.texture is not None and look.uv is not None:
        uv = look.uv.reshape(-1, 2).astype(np.float32)
        rgba = np.dstack([look.texture, np.full(look.texture.shape[:2], 255, np.uint8)])
        material.base_color_texture = sapien.render.RenderTexture2D(np.ascontiguousarray(rgba), "R8G8B8A8Unorm")
    return sapien.render.RenderShapeTriangleMesh(
        corners.reshape(-1, 3).astype(np.float32),
        np.arange(corners.size // 3, dtype=np.uint32).reshape(-1, 3),
        np.repeat(normals, 3, axis=0).astype(np.float32),
        uv,
        material,
    )
