"""Liquids: volumes that move between vessels by rule, without drops and waves.

A vessel's inside is an upright cylinder. What its tilt leaves no room for is spilled. A pipette draws what the tip is
under the surface of, else air, which leaves first; what leaves the tip inside a vessel is in there, else it is spilled.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.values import Pose
from grip_bt.base.yaml.models import NotNegative, Positive, Settings

MILLILITRE = 1e-6
"""[m^3]"""


class VesselConfig(Settings):
    """The inside of an object that liquids can be in: a cylinder about its upright axis, open at the top."""

    radius: Positive
    """Of its inside [m]."""
    depth: Positive
    """From its bottom to its rim [m]."""
    bottom: NotNegative = 0.003
    """Height of its bottom above the object's underside [m]."""
    volume: NotNegative = 0.0
    """What is in it at first [ml]."""

    def level(self, volume: float) -> float:
        """Return how high a volume [ml] stands in it [m]; when it is tilted, on its axis."""
        return volume * MILLILITRE / (np.pi * self.radius**2)

    def capacity(self, cosine: float) -> float:
        """Return how much it holds [ml] when its axis is tilted, by the angle's cosine.

        As soon as the surface meets the bottom, that is a cylindrical wedge.
        """
        if cosine <= 0:
            return 0.0
        r, h = self.radius, self.depth
        slope = float(np.sqrt(max(0.0, 1 - cosine**2))) / cosine
        if 2 * r * slope <= h:
            return float(np.pi * r**2 * (h - r * slope)) / MILLILITRE
        wet = h / slope
        half = np.sqrt(wet * (2 * r - wet))
        wedge = half * (3 * r**2 - half**2) + 3 * r**2 * (wet - r) * np.arccos(1 - wet / r)
        return float(h / (3 * wet) * wedge) / MILLILITRE


class Liquids:
    """What is in the vessels of a world, and what was spilled [ml].

    Args:
        where: returns the pose of a vessel's underside's middle in world.
        upright: returns the cosine of its axis' tilt, in less time.
    """

    def __init__(self, where: Callable[[str], Pose], upright: Callable[[str], float]):
        self._where, self._upright, self._vessels = where, upright, dict[str, VesselConfig]()
        self.volumes, self.spilled = dict[str, float](), 0.0

    def add(self, name: str, vessel: VesselConfig) -> None:
        """Have one more vessel, with what is in it."""
        self._vessels[name], self.volumes[name] = vessel, vessel.volume

    def remove(self, name: str) -> None:
        """Forget a vessel, if it is one, and what is in it."""
        self._vessels.pop(name, None)
        self.volumes.pop(name, None)

    def settle(self) -> None:
        """Spill what tilted or overfull vessels can't hold."""
        for name, volume in self.volumes.items():
            if volume:
                kept = min(volume, self._vessels[name].capacity(self._upright(name)))
                self.volumes[name], self.spilled = kept, self.spilled + volume - kept

    def draw(self, tip: Array, most: float) -> float:
        """Take at most a volume [ml] from where a tip is in world, and return how much there was."""
        name = self._around(tip)
        if not name:
            return 0.0
        vessel, pose = self._vessels[name], self._where(name)
        surface = pose.apply([(0.0, 0.0, vessel.bottom + vessel.level(self.volumes[name]))])[0]
        drawn = min(most, self.volumes[name]) if tip[2] < surface[2] else 0.0
        self.volumes[name] -= drawn
        return drawn

    def release(self, tip: Array, volume: float) -> None:
        """Put a volume [ml] to where a tip is."""
        if name := self._around(tip):
            self.volumes[name] += volume
        else:
            self.spilled += volume

    def kept(self) -> Array:
        """Return all volumes as numbers."""
        return np.array([*self.volumes.values(), self.spilled])

    def put_back(self, kept: Iterable[float]) -> None:
        """Bring back volumes that were kept."""
        *volumes, self.spilled = map(float, kept)
        self.volumes = dict(zip(self.volumes, volumes, strict=True))

    def _around(self, tip: Array) -> str:
        """Return the vessel that a point is inside of; empty for none."""
        for name, vessel in self._vessels.items():
            x, y, z = self._where(name).inverse().apply([tip])[0]
            if np.hypot(x, y) <= vessel.radius and 0 <= z - vessel.bottom <= vessel.depth:
                return name
        return ""
