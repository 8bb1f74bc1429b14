"""Synergies of a hand: the few ways in which its joints move together, found in postures (PCA).

Source: Santello, Flanders, Soechting, "Postural Hand Synergies for Tool Use", J. Neuroscience 18(23), 1998.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from grip_bt.base.arrays import Array
from grip_bt.base.values import JointState

_NOTHING = 1e-9


@dataclass(frozen=True)
class Synergies:
    """A linear space of postures: middle + weights @ directions.

    Attributes:
        names: n joints.
        middle: the mean of the postures, shape (n,) [rad].
        directions: shape (k, n) [rad], at right angles to one another, the strongest first; each as long as the
            postures reach, so that these have weights in [-1, 1].
    """

    names: tuple[str, ...]
    middle: Array
    directions: Array

    @classmethod
    def of(cls, postures: Iterable[JointState], most: int | None = None) -> Synergies:
        """Find the synergies of postures of the same joints."""
        rows = list(postures)
        names = rows[0].names
        table = np.stack([row.ordered(names) for row in rows])
        middle = table.mean(axis=0)
        axes = np.linalg.svd(table - middle, full_matrices=False)[2]
        reach = np.abs((table - middle) @ axes.T).max(axis=0)
        kept = reach > _NOTHING
        # The sign of an axis is arbitrary: a positive weight goes the way in which the joints flex altogether.
        signs = np.where(axes.sum(axis=1) < 0, -1.0, 1.0)
        return cls(names, middle, (axes * (reach * signs)[:, None])[kept][:most])

    def posture(self, weights: Sequence[float]) -> JointState:
        """Return the posture of some weights; those that aren't given are 0.

        Raises:
            ValueError: there are more weights than synergies, or one isn't finite.
        """
        given = np.asarray(weights, dtype=float)
        if given.ndim != 1 or len(given) > len(self.directions) or not np.isfinite(given).all():
            raise ValueError(f"weights are at most {len(self.directions)} finite numbers, not {list(weights)}")
        return JointState(self.names, self.middle + given @ self.directions[: len(given)])

    def weights(self, posture: JointState) -> Array:
        """Return the weights of the nearest posture in the space, shape (k,)."""
        away = posture.ordered(self.names) - self.middle
        return (self.directions @ away) / (self.directions**2).sum(axis=1)


def finger_posture(
    opened: JointState, closed: JointState, fingers: Mapping[str, Sequence[str]], closing: Mapping[str, float]
) -> JointState:
    """Return the posture of the joints of some fingers, each between open (0) and closed (1)."""
    start, end = opened.as_mapping(), closed.as_mapping()
    part = {joint: share for finger, share in closing.items() for joint in fingers[finger]}
    return JointState.from_mapping({j: start[j] + (end[j] - start[j]) * share for j, share in part.items()})
