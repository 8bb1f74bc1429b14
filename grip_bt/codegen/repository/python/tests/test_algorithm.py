"""The algorithm alone; run by `pytest` in this folder's parent."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
from algorithm import find


def test_the_highest_point_is_found():
    """Of several points."""
    points = np.array([[0.0, 0.0, 0.1], [0.2, 0.0, 0.3], [0.0, 0.1, 0.2]])
    assert list(find(points)) == [0.2, 0.0, 0.3]


def test_an_empty_cloud_has_none():
    """Nothing is invented."""
    assert find(np.zeros((0, 3))) is None
