"""A renderer that draws triangles with OpenCV 5; it needs no Vulkan and no GPU.

OpenCV's z-buffer (`cv2.triangleRasterize`, flat shading) is used for one thing only: *which triangle* does each pixel
see. The number of the triangle is drawn in place of a colour, exactly up to 2^24. Depth, normal, label and colour are
then computed here, in double precision, from the plane of that triangle: exact, whatever the precision of the z-buffer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from grip_bt.base.arrays import Array, Mask
from grip_bt.base.values import CameraInfo, Pose
from grip_sim.cameras import AMBIENT, BACKGROUND, DIFFUSE, LIGHT, NEAR, NOTHING, Frame, Places
from grip_sim.cameras.looks import Target, box_corners
from grip_sim.cameras.mesh_files import Look
from grip_sim.specs import Colour

FLIP = np.array([1, -1, -1], np.float32)
"""OpenCV draws along -z, y up."""
MOST = 1 << 24
"""Whole numbers that a float32 holds."""


class _Texture(NamedTuple):
    """A picture on the triangles first, first + 1, ...; place in it = slope @ point + shift."""

    first: int
    slopes: Array  # (n, 2, 3)
    shifts: Array  # (n, 2)
    picture: NDArray[np.uint8]


class RasterRenderer:
    """Draws bodies by their triangles.

    Args:
        info: the camera, with its principal point in the middle.
        far: nothing is seen beyond [m].
        visual: whether their visuals are drawn where they have some, not their collision shapes.
    """

    def __init__(self, info: CameraInfo, far: float, targets: Sequence[Target], visual: bool = True):
        self._info, self._far = info, far
        self._names = tuple(target.name for target in targets)
        self._looks = [[_drawable(look, target.colour) for look in target.looks(visual)] for target in targets]
        sizes = [sum(len(look.triangles) for look in looks) for looks in self._looks]
        if sum(sizes) >= MOST:
            raise ValueError(f"{sum(sizes)} triangles; a camera can draw {MOST}")
        reach = [np.stack([*map(_reach, looks)] or [np.zeros((2, 3))]) for looks in self._looks]
        boxes = [box_corners(each[:, 0].min(axis=0), each[:, 1].max(axis=0)) for each in reach]
        self._boxes, self._filled = np.array(boxes, float).reshape(-1, 8, 3), np.array(sizes, int) > 0
        self._fill(np.zeros(len(targets), bool))
        self._rays = np.ascontiguousarray(info.rays().reshape(-1, 3).T[:2])  # their z is 1
        self._field = 2 * np.arctan(info.height / 2 / info.matrix[1, 1])
        self._slope = np.array([info.width, info.height]) / 2 / info.matrix[[0, 1], [0, 1]]
        self._settings = cv2.TriangleRasterizeSettings()
        self._settings.setShadingType(cv2.RASTERIZE_SHADING_FLAT)
        self._settings.setCullingMode(cv2.RASTERIZE_CULLING_NONE)  # it was done before

    def _fill(self, known: Mask) -> None:
        """Have the triangles of these bodies ready; a robot that is never in view costs nothing."""
        self._known = known
        whose = [row for row in np.flatnonzero(known).tolist() for _ in self._looks[row]]
        looks = [look for row in np.flatnonzero(known).tolist() for look in self._looks[row]]
        points = np.cumsum([0, *(len(look.points) for look in looks)])
        firsts = np.cumsum([0, *(len(look.triangles) for look in looks)])
        bodies = np.searchsorted(whose, np.arange(len(self._looks) + 1))
        self._starts, self._firsts = points[bodies].tolist(), firsts[bodies].tolist()  # each ends where the next begins
        parts = [look.triangles + start for look, start in zip(looks, points, strict=False)]
        self._textures = [
            _texture(int(first), look, look.uv, look.texture)
            for look, first in zip(looks, firsts, strict=False)
            if look.texture is not None and look.uv is not None
        ]
        colours = [np.tile(np.array(look.colour, np.float32), (len(look.triangles), 1)) for look in looks]
        self._points = np.concatenate([np.empty((0, 3)), *(look.points for look in looks)]).astype(np.float32)
        self._triangles = np.concatenate([np.empty((0, 3)), *parts]).astype(np.int32)
        self._planes = np.concatenate([np.empty((0, 4)), *map(_planes, looks)])
        self._coarse = self._planes.astype(np.float32)
        self._colours = np.concatenate([np.empty((0, 3), np.float32), *colours])
        self._whose = np.repeat(np.array(whose, np.int16), np.diff(firsts))

    def draw(self, pose: Pose, places: Places) -> Frame:
        """Return what is seen from a pose of bodies at places; see `Renderer`."""
        turn = pose.rotation()
        seen = Places(turn.T @ places.rotations, (places.positions - pose.position) @ turn)
        corners, rows, local = self._may_be_seen(seen)
        number = np.zeros((self._info.height, self._info.width, 3), np.float32)
        if len(rows):
            depth = np.full(number.shape[:2], self._far, np.float32)
            colours = np.zeros((len(corners), 3), np.float32)
            colours[::3, 0] = rows + 1  # flat shading takes the colour of the first corner
            triangles, eye = np.arange(len(corners), dtype=np.int32).reshape(-1, 3), np.eye(4, dtype=np.float32)
            corners = corners * FLIP
            cv2.triangleRasterize(
                corners, triangles, colours, number, depth, eye, self._field, NEAR / 2, self._far, self._settings
            )
        return self._shaded(number[:, :, 0].ravel().astype(np.int32) - 1, seen, pose, local)

    def _may_be_seen(self, places: Places) -> tuple[NDArray[np.float32], NDArray[np.int32], NDArray[np.float32]]:
        """Return the corners and the numbers of triangles that may have a pixel, and all points, of bodies in view."""
        rotations, shifts = places
        far, near = [np.empty(0, np.int32)], [np.empty(0, np.int32)]
        boxes = self._boxes @ rotations.transpose(0, 2, 1) + shifts[:, None]
        crossing = boxes[:, :, 2].min(axis=1) < 2 * NEAR
        seen = self._in_view(boxes)
        if (seen & ~self._known).any():
            self._fill(seen | self._known)
        local = np.empty_like(self._points)
        for row in np.flatnonzero(seen).tolist():
            rotation, shift, first = rotations[row], shifts[row], self._firsts[row]
            points = slice(self._starts[row], self._starts[row + 1])
            np.matmul(self._points[points], rotation.T.astype(np.float32), out=local[points])
            local[points] += shift.astype(np.float32)
            eye = np.append(-(rotation.T @ shift), -1).astype(np.float32)
            facing = np.flatnonzero(self._coarse[first : self._firsts[row + 1]] @ eye > -1e-6).astype(np.int32)
            (near if crossing[row] else far).append(facing + first)
        rows, cut = np.concatenate(far), np.concatenate(near)
        whole = local.take(self._triangles.take(rows, axis=0).ravel(), axis=0)
        clipped, which = _clipped(local[self._triangles[cut]])
        return np.concatenate([whole, clipped]), np.concatenate([rows, cut[which]]), local

    def _in_view(self, boxes: Array) -> Mask:
        """Tell of boxes, shape (n, 8, 3), whether they don't lie beside, behind or beyond what the camera sees."""
        (x, y, z), (right, down) = boxes.transpose(2, 0, 1), self._slope
        sides = (x > right * z, x < -right * z, y > down * z, y < -down * z, z < NEAR, z > self._far)
        return self._filled & ~np.any([side.all(axis=1) for side in sides], axis=0)

    def _shaded(self, number: NDArray[np.int32], places: Places, pose: Pose, local: NDArray[np.float32]) -> Frame:
        shape, (rotations, shifts) = (self._info.height, self._info.width), places
        drawn = np.zeros(len(self._planes) + 1, bool)
        drawn[number] = drawn[-1] = True  # the last one stands for no triangle, -1
        seen = np.flatnonzero(drawn[:-1])  # the triangles of which there is a pixel
        row = (np.cumsum(drawn, dtype=np.int32) - 1).take(number)  # of each pixel in `seen`, or behind it
        whose = self._whose[seen]
        normals = np.zeros((len(seen) + 1, 3))
        normals[:-1] = np.einsum("nij,nj->ni", rotations[whose], self._planes[seen, :3])
        offsets = self._planes[seen, 3] + np.einsum("ni,ni->n", normals[:-1], shifts[whose])
        # per pixel, in as few passes as there can be: depth = offset / (normal . ray), with unit z of the ray
        x, y, z = (part.take(row) for part in np.ascontiguousarray(normals.T))
        along = x * self._rays[0] + y * self._rays[1] + z
        reach = local[self._triangles[seen], 2]
        low, high = np.append(reach.min(axis=1), 0), np.append(reach.max(axis=1), 0)
        found = np.append(offsets, -0.0).take(row) / np.minimum(along, -1e-12)
        found = np.clip(found, low.take(row), high.take(row))  # those seen edge-on have no other depth
        labels = np.append(whose, np.int16(NOTHING)).take(row).reshape(shape)
        facing = np.stack([x, y, z], axis=-1, dtype=np.float32, casting="same_kind").reshape(*shape, 3)
        light = AMBIENT + DIFFUSE * np.clip(normals @ (pose.rotation().T @ LIGHT), 0, 1)
        colours = np.full((len(seen) + 1, 4), (*BACKGROUND, 0), np.uint8)  # four bytes are taken as one number
        colours[:-1, :3] = np.clip(self._colours[seen] * light[:-1, None], 0, 255)
        image = np.ascontiguousarray(colours.view(np.uint32).take(row).view(np.uint8).reshape(-1, 4)[:, :3])
        for texture in self._textures:
            self._put_on(texture, image, number, found, light.take(row), places)
        depth = found.astype(np.float32).reshape(shape)
        return Frame(image.reshape(*shape, 3), depth, labels, self._names, facing, pose)

    def _put_on(
        self,
        texture: _Texture,
        image: NDArray[np.uint8],
        number: NDArray[np.int32],
        depth: Array,
        light: Array,
        at: Places,
    ) -> None:
        mine = np.flatnonzero((number >= texture.first) & (number < texture.first + len(texture.slopes)))
        if not mine.size:
            return
        body = self._whose[texture.first]
        rays = np.append(self._rays[:, mine], np.ones((1, mine.size)), axis=0).T
        points = (rays * depth[mine, None] - at.positions[body]) @ at.rotations[body]
        rows = number[mine] - texture.first
        u, v = (np.einsum("nij,nj->ni", texture.slopes[rows], points) + texture.shifts[rows]).T
        height, width = texture.picture.shape[:2]
        columns, lines = np.floor(u * width).astype(int) % width, np.floor((1 - v) * height).astype(int) % height
        image[mine] = texture.picture[lines, columns] * light[mine, None]


@lru_cache(maxsize=256)  # of a robot that is the same in another world
def _drawable(look: Look, colour: Colour) -> Look:
    """Return it in a colour, without triangles that have no area, and so no plane."""
    one, two, three = look.points.astype(np.float32)[look.triangles].astype(float).transpose(1, 0, 2)
    whole = np.linalg.norm(np.cross(two - one, three - one), axis=1) > 0
    uv = None if look.uv is None else look.uv[whole]
    return replace(look, triangles=look.triangles[whole], colour=look.colour or colour, uv=uv)


@lru_cache(maxsize=256)
def _reach(look: Look) -> Array:
    """Return the lowest and the highest corner along the axes, shape (2, 3)."""
    return np.stack([look.points.min(axis=0), look.points.max(axis=0)])


@lru_cache(maxsize=256)
def _planes(look: Look) -> Array:
    """Return normal and offset of each triangle, shape (n, 4)."""
    one, two, three = look.points[look.triangles].transpose(1, 0, 2)
    normals = np.cross(two - one, three - one)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    return np.column_stack([normals, np.einsum("ij,ij->i", normals, one)])


def _texture(first: int, look: Look, uv: Array, picture: NDArray[np.uint8]) -> _Texture:
    corners = look.points[look.triangles]
    edges, steps = corners[:, 1:] - corners[:, :1], uv[:, 1:] - uv[:, :1]
    slopes = np.transpose(np.linalg.pinv(edges) @ steps, (0, 2, 1))
    return _Texture(first, slopes, uv[:, 0] - np.einsum("nij,nj->ni", slopes, corners[:, 0]), picture)


def _clipped(corners: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.intp]]:
    """Cut off what lies nearer than NEAR; return corners of triangles, and of which given one each is a part."""
    ahead = corners[:, :, 2] > NEAR
    whole = np.flatnonzero(ahead.all(axis=1))
    found, rows = list(corners[whole]), list(whole)
    for row in np.flatnonzero(ahead.any(axis=1) & ~ahead.all(axis=1)):
        ring = []
        for p, q in zip(corners[row], np.roll(corners[row], -1, axis=0), strict=True):
            ring += [p] if p[2] > NEAR else []
            ring += [p + (q - p) * ((NEAR - p[2]) / (q[2] - p[2]))] if (p[2] > NEAR) != (q[2] > NEAR) else []
        for one, two in zip(ring[1:], ring[2:], strict=False):
            found.append(np.stack([ring[0], one, two]))
            rows.append(row)
    return np.array(found, np.float32).reshape(-1, 3), np.array(rows, dtype=np.intp)
