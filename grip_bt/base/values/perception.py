"""What cameras give: images, depth, clouds and the camera's own geometry."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from grip_bt.base.arrays import Array, ComparesArrays

from .pose import Pose


@dataclass(frozen=True, slots=True, eq=False)
class PointCloud(ComparesArrays):
    """Points in `frame`.

    Attributes:
        points: shape (n, 3) float32 [m].
        colors: shape (n, 3) uint8, red green blue, or None.
        time: when it was captured, on the run's clock [s].
    """

    points: NDArray[np.float32]
    colors: NDArray[np.uint8] | None = None
    frame: str = "world"
    time: float = 0.0

    def __post_init__(self) -> None:
        self._freeze((None, 3), "points", dtype=np.float32)
        self._freeze((len(self.points), 3), "colors", dtype=np.uint8)

    def __repr__(self) -> str:
        return f"PointCloud({len(self.points)} points, frame={self.frame!r})"


@dataclass(frozen=True, slots=True, eq=False)
class CameraInfo(ComparesArrays):
    """A pinhole camera.

    Attributes:
        width: columns [px].
        height: rows [px].
        matrix: intrinsic matrix, shape (3, 3) [px]; pixel centres lie at whole numbers + 0.5.
        pose: the optical frame (x right, y down, z forward) in `pose.frame`.
    """

    width: int
    height: int
    matrix: Array
    pose: Pose = field(default_factory=Pose)

    def __post_init__(self) -> None:
        self._freeze((3, 3), "matrix")

    def rays(self) -> Array:
        """Return the direction of each pixel with unit z, in the optical frame, shape (height, width, 3)."""
        u, v = np.meshgrid(np.arange(self.width) + 0.5, np.arange(self.height) + 0.5)
        k = self.matrix
        return np.stack([(u - k[0, 2]) / k[0, 0], (v - k[1, 2]) / k[1, 1], np.ones_like(u)], axis=-1)

    def project(self, points: Array) -> Array:
        """Map points of shape (n, 3) [m], given in `pose.frame`, to pixels, shape (n, 2)."""
        local = (np.asarray(points, dtype=float) - self.pose.position) @ self.pose.rotation()
        image = local @ self.matrix.T
        return image[:, :2] / image[:, 2:3]


@dataclass(frozen=True, slots=True, eq=False)
class Image(ComparesArrays):
    """A colour image.

    Attributes:
        pixels: shape (height, width, 3) uint8, red green blue.
        frame: name of the camera's optical frame.
        time: when it was captured, on the run's clock [s].
    """

    pixels: NDArray[np.uint8]
    frame: str = ""
    time: float = 0.0

    def __post_init__(self) -> None:
        self._freeze((None, None, 3), "pixels", dtype=np.uint8)

    def __repr__(self) -> str:
        return f"Image({self.pixels.shape[1]}x{self.pixels.shape[0]}, frame={self.frame!r})"


@dataclass(frozen=True, slots=True, eq=False)
class DepthImage(ComparesArrays):
    """A depth image: distance along the optical axis.

    Attributes:
        depth: shape (height, width) float32 [m]; 0 where nothing was seen.
        time: when it was captured, on the run's clock [s].
    """

    depth: NDArray[np.float32]
    info: CameraInfo
    time: float = 0.0

    def __post_init__(self) -> None:
        self._freeze((self.info.height, self.info.width), "depth", dtype=np.float32)

    def points(self) -> Array:
        """Return a point per pixel in `info.pose.frame`, shape (height, width, 3) [m]; NaN where nothing was seen."""
        local = self.info.rays() * self.depth[..., None]
        local[self.depth <= 0] = np.nan
        return local @ self.info.pose.rotation().T + self.info.pose.position

    def __repr__(self) -> str:
        return f"DepthImage({self.info.width}x{self.info.height})"


@dataclass(frozen=True, slots=True, eq=False)
class RgbdFrame(ComparesArrays):
    """One capture of an RGB-D camera; image and depth have the same size and view."""

    image: Image
    depth: DepthImage

    def cloud(self) -> PointCloud:
        """Return the seen points in the frame of the camera's pose, with their colours."""
        points = self.depth.points().reshape(-1, 3)
        seen = np.isfinite(points[:, 0])
        colors = self.image.pixels.reshape(-1, 3)[seen]
        return PointCloud(points[seen].astype(np.float32), colors, self.depth.info.pose.frame, self.depth.time)
