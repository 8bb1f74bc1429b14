"""Whether joints that somebody names are those of an arm."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from grip_bt.base.arrays import Array
from grip_bt.base.errors import UnknownNameError


def require_joints(names: Sequence[str], allowed: Sequence[str], arm: str) -> None:
    """Verify that an arm has the joints that are named.

    Raises:
        UnknownNameError: it lacks one.
    """
    for name in names:
        if name not in allowed:
            raise UnknownNameError("joint", name, allowed, where=f"arm {arm!r}")


def same_joints(position: ArrayLike, names: Sequence[str]) -> Array:
    """Return a copy of the positions of these joints, shape (n,).

    Raises:
        ValueError: they are of another number of joints.
    """
    row = np.array(position, dtype=float)
    if row.shape != (len(names),):
        raise ValueError(f"the state is of another robot: this one has the joints {', '.join(names)}, not {row.shape}")
    return row
