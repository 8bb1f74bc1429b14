"""What a depth sensor does to a perfect frame, as a value. A seed and a frame's number give the same frame, bit by bit.

RealSense: a stereo camera finds disparities to a part of a pixel, so that depth is off by z^2 * subpixel / (f * B) RMS
(Intel, "Best-Known-Methods for Tuning Intel RealSense D400 Depth Cameras for Best Performance", 2019, which measures
0.05-0.1 px on textured walls), and comes in steps of as many units. B = 50 mm is the D435's base line, its unit 1 mm.

Kinect 2: a time-of-flight camera, whose noise grows about linearly with the distance, from about 1.5 mm at 1 m to
3 mm at 3 m, and with the angle at which a surface is seen (Wasenmueller and Stricker, "Comparison of Kinect v1 and v2
Depth Images in Terms of Accuracy and Precision", ACCV workshops 2016; Fankhauser et al., "Kinect v2 for Mobile Robot
Navigation", ICAR 2015, fits sigma(z, angle)); its pixels at edges fly between what is in front and what is behind.
What is seen at a grazing angle returns nothing to either (Fankhauser et al.; Nguyen, Izadi and Lovell, "Modeling
Kinect Sensor Noise for Improved 3D Reconstruction and Tracking", 3DIMPVT 2012, put the limit at 60-70 degrees of v1).
The figures are of these papers' order; a sensor of one's own is measured, and its fields are given.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field
from pydantic.dataclasses import dataclass

from grip_bt.base.arrays import Array
from grip_bt.base.values import Pose
from grip_bt.base.values.pose import quaternion_of
from grip_bt.base.yaml.models import NotNegative as Amount
from grip_bt.base.yaml.models import Positive

Part = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]


@dataclass(frozen=True, slots=True)
class NoiseSpec:
    """A sensor's faults; all of them are off by default.

    Attributes:
        constant: standard deviation of depth everywhere [m].
        linear: what it grows by with the distance [m/m].
        subpixel: RMS error of a disparity [px]; depth is off by z^2 * subpixel / (f * baseline).
        baseline: between the two cameras of a stereo sensor [m].
        slant: the deviation grows by this part at tan(angle) = 1 between ray and normal.
        grazing: nothing returns from surfaces seen at a larger angle from their normal [rad]; pi / 2 for all do.
        dropout: part of all pixels that give nothing.
        bleeding: part of the pixels at an edge of depth that give something between, or nothing, each as often.
        edge: difference of depth to a neighbour that makes an edge [m].
        unit: depth comes in whole multiples of it [m]; 0 for any depth.
        nearest: nothing is measured nearer than this [m].
        colour: standard deviation of each colour, of 255.
        latency: the frame shows the world as it was so long ago, or up to 1/60 s longer, in simulated time [s].
        misplaced: standard deviation of where a frame says that it was taken, along each axis, anew for each frame [m].
        misturned: likewise of how the camera was turned, about each axis [rad].
    """

    constant: Amount = 0.0
    linear: Amount = 0.0
    subpixel: Amount = 0.0
    baseline: Positive = 0.05
    slant: Amount = 0.0
    grazing: Annotated[float, Field(gt=0, le=np.pi / 2)] = np.pi / 2
    dropout: Part = 0.0
    bleeding: Part = 0.0
    edge: Positive = 0.02
    unit: Amount = 0.0
    nearest: Amount = 0.0
    colour: Amount = 0.0
    latency: Annotated[float, Field(ge=0, le=10)] = 0.0
    misplaced: Amount = 0.0
    misturned: Amount = 0.0

    def deviation(self, depth: Array, focal: float, cosine: Array | float = 1.0) -> Array:
        """Return the standard deviation of depth [m]."""
        straight = self.constant + self.linear * depth + self.subpixel * depth**2 / (focal * self.baseline)
        tangent = np.sqrt(np.maximum(1 - np.square(cosine), 0)) / np.maximum(cosine, 0.05)
        return straight * (1 + self.slant * tangent)

    def on_depth(self, depth: NDArray[np.float32], cosine: Array, focal: float, seed: list[int]) -> NDArray[np.float32]:
        """Return the depth [m] that the sensor gives, 0 where nothing; the same seed gives the same, bit by bit.

        Args:
            depth: the true one, shape (height, width), 0 where nothing is.
            cosine: of the angle between ray and normal, likewise.
            focal: length [px].
        """
        rng = np.random.default_rng(seed)  # as many numbers are drawn whatever is seen
        off, lot, share = rng.standard_normal(depth.shape), rng.random(depth.shape), rng.random(depth.shape)
        other = _across_edges(depth, self.edge)
        at_edge = (other != depth) & (depth > 0)
        bleeds = at_edge & (lot < self.bleeding / 2)
        lost = at_edge & (lot >= self.bleeding / 2) & (lot < self.bleeding)
        lost |= (cosine < np.cos(self.grazing)) | (rng.random(depth.shape) < self.dropout)
        true, between = depth.astype(float), bleeds & (other > 0)
        true[between] += share[between] * (other - depth)[between]
        found = true + off * self.deviation(true, focal, cosine)
        if self.unit:
            found = np.round(found / self.unit) * self.unit
        return np.where((depth == 0) | lost | (found <= self.nearest), 0, found).astype(np.float32)

    def on_image(self, image: NDArray[np.uint8], seed: list[int]) -> NDArray[np.uint8]:
        """Return the image that the sensor gives, likewise."""
        if not self.colour:
            return image
        found = np.random.default_rng([*seed, 1]).standard_normal(image.shape, np.float32)
        found *= self.colour
        found += image
        return np.clip(np.rint(found, out=found), 0, 255, out=found).astype(np.uint8)

    def on_pose(self, pose: Pose, seed: list[int]) -> Pose:
        """Return the pose [m] that a frame taken at one says, likewise."""
        if not (self.misplaced or self.misturned):
            return pose
        shift, turn = np.random.default_rng([*seed, 2]).standard_normal((2, 3))
        return pose @ Pose(self.misplaced * shift, quaternion_of(*self.misturned * turn))


def _across_edges(depth: NDArray[np.float32], edge: float) -> NDArray[np.float32]:
    """Return, for each pixel beside an edge, the depth on its other side; of others their own."""
    found = depth.copy()
    for axis in (0, 1):
        for step in (1, -1):
            near, far = (slice(None, -1), slice(1, None)) if step > 0 else (slice(1, None), slice(None, -1))
            here, there = ((near,), (far,)) if axis == 0 else ((slice(None), near), (slice(None), far))
            jump = np.abs(depth[there] - depth[here]) > edge
            found[here] = np.where(jump, depth[there], found[here])
    return found


PRESETS = {
    "realsense": NoiseSpec(
        subpixel=0.08, baseline=0.05, slant=0.3, grazing=1.40, dropout=0.002, bleeding=0.5, unit=1e-3, nearest=0.105,
        colour=1.5, latency=0.033,
    ),
    "kinect2": NoiseSpec(
        constant=0.75e-3, linear=0.75e-3, slant=0.5, grazing=1.31, dropout=0.001, bleeding=0.8, unit=1e-3, nearest=0.5,
        colour=2.0, latency=0.045,
    ),
}  # fmt: skip


def _named(said: object) -> object:
    if isinstance(said, str):
        if said not in PRESETS:
            raise ValueError(f"there is no sensor {said!r}; there are {', '.join(PRESETS)}, or give its fields")
        return PRESETS[said]
    return said


Noise = Annotated[
    NoiseSpec, BeforeValidator(_named, json_schema_input_type=Literal["realsense", "kinect2"] | NoiseSpec)
]
