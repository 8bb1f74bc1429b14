"""Contacts between bodies, as values."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from grip_sim.specs import Vector


class Contact(NamedTuple):
    """Two bodies that touch.

    Attributes:
        first: the one's name.
        second: the other's.
        push: force on the first along the surface's normal, without friction, in world [N].
    """

    first: str
    second: str
    push: Vector

    @property
    def force(self) -> float:
        """How hard they press on each other [N]."""
        return float(np.linalg.norm(self.push))

    def push_on(self, name: str) -> Vector:
        """Return the force on one of the two, in world [N]."""
        x, y, z = self.push
        return (x, y, z) if name == self.first else (-x, -y, -z)
