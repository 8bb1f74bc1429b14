"""Names for arrays of numbers. Units are those of the joints and frames that a function is about."""

import numpy as np
from numpy.typing import NDArray

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
