"""A camera that casts rays against the collision shapes, the oracle of the cameras that draw triangles.

What never moves is boxes: their image is computed once, for all pixels together (slab method). Per frame only those
pixels are cast that may see something which moves: those within the projected bounding boxes of its bodies.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from grip_bt.base.arrays import Array, Mask
from grip_sim.cameras import AMBIENT, BACKGROUND, DIFFUSE, LIGHT, NOTHING, Frame
from grip_sim.cameras.looks import Target
from grip_sim.physics import physx
from grip_sim.specs import BoxSpec, CameraSpec


class RayCamera:
    """A camera that stands still.

    Args:
        spec: where it is and how it sees.
        system: the physics that it looks into.
        still: boxes that never move, and the bodies that stand for them.
        moving: everything else.
    """

    def __init__(
        self,
        spec: CameraSpec,
        system: physx.PhysxCpuSystem,
        still: Sequence[tuple[BoxSpec, Target]],
        moving: Sequence[Target],
    ):
        self.spec, self.info, self._system = spec, spec.info(), system
        rays = self.info.rays().reshape(-1, 3)
        self._stretch = np.linalg.norm(rays, axis=1)  # distance along the ray per metre of depth
        self._directions = (rays / self._stretch[:, None]) @ self.info.pose.rotation().T
        self._directions32 = self._directions.astype(np.float32)
        self._origin = self.info.pose.position.astype(np.float32)
        self._moving = list(moving)
        targets = [t for _, t in still] + self._moving
        self._names = tuple(t.name for t in targets)
        self._colours = np.array([t.colour for t in targets] + [BACKGROUND], dtype=float)
        # the binding returns one Python object per component, as long as somebody keeps it: `targets` does
        self._index = {t.body: i for i, t in enumerate(targets)}
        self._still = self._cast_boxes([box for box, _ in still])

    def capture(self) -> Frame:
        """Take one frame of the scene as it is now."""
        distance, normals, labels = self._still
        distance, normals, labels = distance.copy(), normals.copy(), labels.copy()
        pixels = np.flatnonzero(self._may_see_moving())
        hits: list[int] = []
        found: list[float] = []
        facing: list[Array] = []
        what: list[int] = []
        raycast, origin, far = self._system.raycast, self._origin, self.spec.far
        for pixel, direction in zip(pixels.tolist(), self._directions32[pixels], strict=True):
            hit = raycast(origin, direction, far)
            if hit is not None:
                hits.append(pixel)
                found.append(hit.distance)
                facing.append(hit.normal)
                what.append(self._index.get(hit.component, NOTHING))
        if hits:
            distance[hits], normals[hits], labels[hits] = found, np.array(facing), what
        return self._frame(distance, normals, labels)

    def _frame(self, distance: Array, normals: Array, labels: NDArray[np.int16]) -> Frame:
        shape = (self.spec.height, self.spec.width)
        light = AMBIENT + DIFFUSE * np.clip(normals @ LIGHT, 0, 1)
        light[labels == NOTHING] = 1.0
        image = np.clip(self._colours[labels] * light[:, None], 0, 255).astype(np.uint8)
        depth = (distance / self._stretch).astype(np.float32)
        facing = (normals @ self.info.pose.rotation()).astype(np.float32).reshape(*shape, 3)
        facing[labels.reshape(shape) == NOTHING] = 0
        image, depth, labels = image.reshape(*shape, 3), depth.reshape(shape), labels.reshape(shape)
        return Frame(image, depth, labels, self._names, facing, self.info.pose)

    def _cast_boxes(self, boxes: Sequence[BoxSpec]) -> tuple[Array, Array, NDArray[np.int16]]:
        """Return distance [m], normal and label of what each ray hits first, boxes along the axes (Kay and Kajiya)."""
        count = len(self._directions)
        distance, normals = np.full(count, np.inf), np.zeros((count, 3))
        labels = np.full(count, NOTHING, dtype=np.int16)
        with np.errstate(divide="ignore"):
            inverse = 1 / self._directions
        for label, box in enumerate(boxes):
            one = (np.array(np.subtract(box.centre, np.array(box.size) / 2)) - self._origin) * inverse
            two = (np.array(np.add(box.centre, np.array(box.size) / 2)) - self._origin) * inverse
            enter, leave = np.minimum(one, two), np.maximum(one, two).min(axis=1)
            axis, near = enter.argmax(axis=1), enter.max(axis=1)
            better = (near <= leave) & (near > 0) & (near < np.minimum(distance, self.spec.far))
            rows, sides = np.flatnonzero(better), axis[better]
            distance[rows], labels[rows], normals[rows] = near[rows], label, 0
            normals[rows, sides] = -np.sign(self._directions[rows, sides])
        distance[np.isinf(distance)] = 0
        return distance, normals, labels

    def _may_see_moving(self) -> Mask:
        mask = np.zeros((self.spec.height, self.spec.width), dtype=bool)
        for target in self._moving:
            corners = np.array(list(itertools.product(*np.array(_bounds(target.body)).T)))
            local = (corners - self.info.pose.position) @ self.info.pose.rotation()
            if np.all(local[:, 2] <= 1e-3):
                continue  # behind the camera
            if np.any(local[:, 2] <= 1e-3):
                mask[:] = True  # around the camera: its projection has no bounds
                break
            pixels = self.info.project(corners)
            (u0, v0), (u1, v1) = np.floor(pixels.min(axis=0)), np.ceil(pixels.max(axis=0))
            mask[max(0, int(v0)) : max(0, int(v1)), max(0, int(u0)) : max(0, int(u1))] = True
        return mask.ravel()


def _bounds(body: physx.PhysxRigidBaseComponent) -> Array:
    return np.asarray(body.get_global_aabb_fast())
