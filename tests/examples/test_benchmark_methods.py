"""The benchmark's methods to grasp, by themselves: where a box lies that is seen from above, each closes across it."""

import importlib.util
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from grip_bt.base.values import Pose

EXAMPLES = Path(__file__).parents[2] / "examples"
COMPONENTS = EXAMPLES / "benchmark" / "components"
AWAY, FOCAL = 0.9, 536.0
"""Of the camera above the table [m], [px]."""
PIXEL = AWAY / FOCAL
LONG, SHORT, HIGH = 0.090, 0.040, 0.050


@cache
def loaded(path):
    file = EXAMPLES / path
    spec = importlib.util.spec_from_file_location(f"{file.stem}_under_test", file)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def heights(angle, spot, noise=0.001):
    """A box on a table as a noisy camera above sees it: heights, shape (240, 320) [m]; its long side at `angle`."""
    rows, columns = np.mgrid[:240, :320]
    x, y = (columns - spot[1]) * PIXEL, (rows - spot[0]) * PIXEL
    along, across = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
    box = (np.abs(along) < LONG / 2) & (np.abs(across) < SHORT / 2)
    return np.where(box, HIGH, 0.0) + np.random.default_rng(0).normal(0, noise, box.shape)


def cloud(angle, spot):
    """The same as points: x along the columns, y along the rows, z up."""
    seen = heights(angle, spot)
    rows, columns = np.mgrid[:240:2, :320:2]
    return np.stack([columns * PIXEL, rows * PIXEL, seen[::2, ::2]], axis=-1).reshape(-1, 3)


def by_pca(angle, spot):
    planner = loaded("benchmark/components/pca_top/planner.py")
    best = planner.plan(cloud(angle, spot))[0]
    return best.position, best.closing[:2], best.width


def by_edges(angle, spot):
    best = loaded("benchmark/components/image_antipodal/rectangles.py").find(
        (AWAY - heights(angle, spot)).astype(np.float32)
    )[0]
    row, column = best.middle
    place = np.array([column * PIXEL, row * PIXEL, AWAY - best.depth])
    return place, np.array([np.cos(best.angle), -np.sin(best.angle)]), best.width * PIXEL


def by_search(angle, spot):
    search = loaded("benchmark/components/cloud_antipodal/search.py")
    best = search.search(cloud(angle, spot))[0]
    return best.bottom + search.LENGTH * best.approach, best.binormal[:2], best.width


def by_network(angle, spot):
    network = loaded("benchmark/components/grasp_network/network.py")
    best = network.predict(network.load(), (AWAY - heights(angle, spot)).astype(np.float32))[0]
    row, column = best.middle
    place = np.array([column * PIXEL, row * PIXEL, AWAY - best.depth])
    return place, np.array([np.cos(best.angle), np.sin(best.angle)]), best.width


METHODS = {by_pca: (8, 0.006), by_edges: (12, 0.012), by_search: (20, 0.015), by_network: (25, 0.015)}
"""Method -> how far its closing line may be turned from the box's short side [deg], its middle from the box's [m]."""


@pytest.mark.parametrize("spot", [(120, 160), (90, 200)])
@pytest.mark.parametrize("angle", np.radians([0, 35, 75, 120, 160]))
@pytest.mark.parametrize("method", METHODS)
def test_each_method_closes_across_the_short_side_of_a_box_in_its_middle(method, angle, spot):
    place, closing, width = method(angle, spot)
    turned, off = METHODS[method]
    short = np.array([-np.sin(angle), np.cos(angle)])
    assert abs(closing @ short) / np.linalg.norm(closing) > np.cos(np.radians(turned))
    along = np.array([np.cos(angle), np.sin(angle)]) @ (place[:2] - np.array(spot[::-1]) * PIXEL)
    assert abs(along) < 2 * off
    assert abs(short @ (place[:2] - np.array(spot[::-1]) * PIXEL)) < off
    assert 0.7 * SHORT < width < 1.5 * SHORT
    assert 0.005 < place[2] < HIGH


def test_where_nothing_lies_nothing_is_proposed():
    table = np.random.default_rng(1).normal(0, 0.001, (240, 320))
    depth = (AWAY - table).astype(np.float32)
    network = loaded("benchmark/components/grasp_network/network.py")
    empty = np.stack([*np.mgrid[:240:2, :320:2] * PIXEL, table[::2, ::2]], axis=-1).reshape(-1, 3)
    assert loaded("benchmark/components/pca_top/planner.py").plan(empty) == []
    assert loaded("benchmark/components/cloud_antipodal/search.py").search(empty) == []
    for unseen in (depth, np.zeros_like(depth)):
        assert loaded("benchmark/components/image_antipodal/rectangles.py").find(unseen) == []
        assert network.predict(network.load(), unseen) == []


@pytest.mark.parametrize("angle", [0.0, 0.7, -2.0])
def test_the_pca_method_sends_a_hand_whose_x_looks_down_and_whose_z_closes(angle):
    closing = np.array([np.cos(angle), np.sin(angle), 0.0])
    x, y, z, w = loaded("benchmark/components/pca_top/planner.py").quaternion(closing)
    rotation = Pose(quaternion=(w, x, y, z)).rotation()
    np.testing.assert_allclose(rotation[:, 0], [0, 0, -1], atol=1e-9)
    np.testing.assert_allclose(rotation[:, 2], closing, atol=1e-9)


def test_weights_are_small():
    assert (COMPONENTS / "grasp_network" / "weights.npz").stat().st_size < 1_000_000
