"""The pipette's nodes: what they find on the bench, how the hand comes to it, and where the tip is and has to go."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from grip_bt.base.failures import NoGraspError
from grip_bt.base.values import PointCloud, Pose
from grip_bt.commanders.description.load import load_robot

EXAMPLE = Path(__file__).parents[2] / "examples" / "pipette"
spec = importlib.util.spec_from_file_location("pipette_under_test", EXAMPLE / "nodes" / "pipette.py")
nodes = importlib.util.module_from_spec(spec)
sys.modules[spec.name] = nodes
spec.loader.exec_module(nodes)
CAMERA = Pose((0.75, 1.2, 0.3))


def ring(x, y, z, radius):
    around = np.linspace(0, 2 * np.pi, 60)
    return np.column_stack([x + radius * np.cos(around), y + radius * np.sin(around), np.full(60, z)])


def context(palm):
    arm = SimpleNamespace(grasp_pose=lambda: palm)
    return SimpleNamespace(
        arm=lambda name: arm, camera=lambda name: SimpleNamespace(info=lambda: SimpleNamespace(pose=CAMERA))
    )


def test_what_stands_in_a_part_of_the_bench_is_found_by_its_rim():
    cloud = PointCloud(
        np.vstack([ring(0.74, 0.06, 0.08, 0.035), ring(0.74, 0.06, 0.003, 0.03), ring(0.7, 0.3, 0.15, 0.016)])
    )
    top = nodes.find.function(cloud, x=[0.6, 0.9], y=[-0.05, 0.15], above=0.07)
    assert top.position == pytest.approx([0.74, 0.06, 0.08], abs=1e-3)
    with pytest.raises(NoGraspError, match="nothing higher than 0.2 m"):
        nodes.find.function(cloud, x=[0.6, 0.9], y=[-0.05, 0.15], above=0.2)


def test_the_hand_comes_from_the_side_with_its_thumb_above_and_closes_around_the_axis():
    top = Pose((0.75, -0.2, 0.3))
    for grasp in nodes.ways.function(top, below_top=0.1, away=0.034):
        assert grasp.pose.rotation()[:, 0] == pytest.approx([0, 0, 1], abs=1e-9)
        at = grasp.pose.inverse().apply([(0.75, -0.2, 0.2)])[0]
        assert at == pytest.approx([0.0, -0.034, nodes.AXIS], abs=1e-9)
        way = grasp.pose.position - grasp.pre_grasp.position
        assert way / np.linalg.norm(way) == pytest.approx(-grasp.pose.rotation()[:, 1], abs=1e-9)
        assert grasp.post_grasp.position - grasp.pose.position == pytest.approx([0, 0, 0.2])


@pytest.mark.parametrize("lean", [(0.0, 0.0), (0.012, -0.008)])
def test_a_tip_that_was_seen_gets_to_where_it_has_to_be(lean):
    palm = nodes.ways.function(Pose((0.75, -0.2, 0.5)), below_top=0.1, away=0.034)[2].pose
    axis = palm.apply([(0.0, -0.034, nodes.AXIS)])[0]
    end = axis + [lean[0], lean[1], -0.19]
    towards = (CAMERA.position - end)[:2] / np.linalg.norm((CAMERA.position - end)[:2])
    heights = np.linspace(0, 0.05, 40)[:, None]
    seen = end + np.hstack([np.tile(nodes.TIP * towards, (40, 1)), heights])
    tip = nodes.tip.function(context(palm), PointCloud(seen), arm="arm", sensor="side", below=[0.15, 0.24])
    assert palm.apply([tip.position])[0] == pytest.approx(end, abs=1e-4)
    goal = nodes.over.function(context(palm), tip, Pose((0.7, 0.3, 0.15)), arm="arm", high=0.2, deep=0.1)
    for pose, height in ((goal["above"], 0.2), (goal["inside"], 0.1)):
        assert pose.apply([tip.position])[0] == pytest.approx([0.7, 0.3, height], abs=1e-4)
    with pytest.raises(NoGraspError, match="isn't seen"):
        nodes.tip.function(context(palm), PointCloud(seen + [0.2, 0, 0]), arm="arm", sensor="side", below=[0.15, 0.24])


def test_the_launch_file_alone_brings_in_the_robot_that_was_taught():
    robot = load_robot(str(EXAMPLE / "bringup" / "launch" / "ur10_shadow.launch.xml"))
    made = load_robot("ur10_shadow")
    assert robot.groups["arm"] == made.groups["arm"]
    assert len(robot.groups["hand"]) == len(made.groups["hand"]) == 22
    assert {"open", "closed"} <= set(robot.named_states["hand"])
    assert robot.grasp_frame.link == "rh_palm"
