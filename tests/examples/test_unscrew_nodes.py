"""The nodes that unscrew a bottle: where they see the cap, and where fingertips and hands go for it."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

from grip_bt.base.failures import NoGraspError
from grip_bt.base.values import PointCloud
from grip_bt.commanders.description.load import load_robot
from grip_bt.commanders.kinematics.fingertips import fingertip_posture
from grip_bt.commanders.kinematics.model import RobotModel

FILE = Path(__file__).parents[2] / "examples" / "unscrew" / "nodes" / "unscrew.py"
spec = importlib.util.spec_from_file_location("unscrew_under_test", FILE)
nodes = importlib.util.module_from_spec(spec)
sys.modules[spec.name] = nodes
spec.loader.exec_module(nodes)
TABLE = {"x": [0.4, 0.7], "y": [-0.15, 0.15]}


def bottle(x, y, step=0.003):
    """Return a cloud of a table with a bottle of 14 cm and its cap, seen from above."""
    row = np.arange(-0.06, 0.06, step)
    around = np.stack(np.meshgrid(row, row), axis=-1).reshape(-1, 2)
    away = np.linalg.norm(around, axis=1)
    height = np.where(away < 0.02, 0.165, np.where(away < 0.03, 0.14, 0.0))
    return PointCloud(np.column_stack([around + [x, y], height]).astype(np.float32))


@pytest.mark.parametrize(("x", "y"), [(0.55, 0.0), (0.531, -0.017)])
def test_the_cap_is_the_highest_thing_there_is(x, y):
    cap = nodes.find_cap.function(bottle(x, y), **TABLE)
    assert cap.position == pytest.approx([x, y, 0.165], abs=0.003)


def test_a_table_without_a_bottle_has_no_cap():
    with pytest.raises(NoGraspError, match="no bottle is seen"):
        nodes.find_cap.function(bottle(0.55, 0.4), **TABLE)


def test_an_allegro_reaches_all_that_a_ratchet_asks_for():
    model = RobotModel(load_robot("panda_allegro"))
    posture = None
    touch = 0.02 + nodes.TIP - 0.012
    for angle, radius in [(24, nodes.WIDE), (24, touch), (0, touch), (-24, touch), (-24, nodes.WIDE)]:
        posture = fingertip_posture(model, nodes.circle(angle, radius), posture)


def test_hands_face_the_bottle():
    cap = nodes.find_cap.function(bottle(0.55, 0.0), **TABLE)
    ways = nodes.ways.function(cap)
    for grasp in ways["turning"]:
        assert grasp.pose.apply([nodes.CENTRE])[0] == pytest.approx(cap.position - [0, 0, 0.009])
        assert grasp.pose.rotation()[:, 2] == pytest.approx([0, 0, -1])
    for grasp in ways["holding"]:
        assert grasp.pose.position[:2] == pytest.approx(cap.position[:2])
        came = grasp.pose.position - grasp.pre_grasp.position
        assert came / np.linalg.norm(came) == pytest.approx(grasp.pose.rotation()[:, 2], abs=1e-6)
