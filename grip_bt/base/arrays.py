"""Arrays by what they hold, and values that hold some: copied, checked, read-only, compared by content."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

Array = NDArray[np.float64]
"""Of any shape; points are `(n, 3)`, transforms `(4, 4)`."""
Configuration = NDArray[np.float64]
"""Positions of the joints that a planner moves, shape `(n,)`."""
Path = NDArray[np.float64]
"""Configurations from start to goal, shape `(k, n)`."""
Mask = NDArray[np.bool_]
"""One truth value for each."""
Indices = NDArray[np.intp]
"""Rows or columns of another array."""


def frozen_array(
    value: ArrayLike, shape: tuple[int | None, ...], name: str, dtype: DTypeLike = np.float64
) -> NDArray[Any]:
    """Return a read-only copy of `value`.

    Args:
        shape: wanted shape; None stands for any length.

    Raises:
        ValueError: the shape differs.
    """
    array = np.array(value, dtype=dtype)
    fits = array.ndim == len(shape) and all(w is None or w == n for w, n in zip(shape, array.shape, strict=True))
    if not fits:
        wanted = tuple("any" if w is None else w for w in shape)
        raise ValueError(f"{name} has shape {array.shape}, not {wanted}")
    array.setflags(write=False)
    return array


class ComparesArrays:
    """Field-by-field equality that understands arrays. Values are not hashable."""

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]

    def _freeze(self, shape: tuple[int | None, ...], *names: str, dtype: DTypeLike = np.float64) -> None:
        """Make fields read-only copies, as `frozen_array` does; those that are None stay."""
        for name in names:
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, frozen_array(value, shape, name, dtype))

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        for field in fields(self):  # type: ignore[arg-type]
            mine, yours = getattr(self, field.name), getattr(other, field.name)
            if isinstance(mine, np.ndarray) or isinstance(yours, np.ndarray):
                if not np.array_equal(mine, yours):
                    return False
            elif mine != yours:
                return False
        return True
