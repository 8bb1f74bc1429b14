"""Leaves that make, rank, count and choose values, and wait for them."""

from __future__ import annotations

import dataclasses

import pytest
from cell import CLOSED, SUCCESS, Cell

from grip_bt.base.values import Pose


@pytest.fixture
def cell(world):
    return Cell(world)


def test_a_grasp_made_of_a_pose_approaches_along_the_palm_and_lifts_up(cell):
    pose = Pose((0.5, 0, 0.2), (0, 1, 0, 0))  # the palm looks down
    leaf = cell.leaf("grasp/make", pose=pose, approach=0.1, lift=0.2, width=0.05, posture=CLOSED)
    assert cell.run(leaf) == SUCCESS
    grasp = cell.data["grasp"]
    assert grasp.pre_grasp.position == pytest.approx([0.5, 0, 0.3])
    assert grasp.post_grasp.position == pytest.approx([0.5, 0, 0.4])
    assert (grasp.width, grasp.posture, grasp.provenance) == (0.05, CLOSED, "task/leaf")


def test_grasps_are_ranked_by_what_the_task_weighs(cell, grasp_at):
    near, far = grasp_at((0.35, -0.4)), grasp_at((0.7, 0.3))
    good = dataclasses.replace(far, quality=0.3)
    cell.run(cell.leaf("grasp/rank", grasps=[near, good]))
    assert [g.pose for g in cell.data["grasps"]] == [good.pose, near.pose]
    cell.run(cell.leaf("grasp/rank", grasps=[near, good], distance=2.0))
    assert [g.pose for g in cell.data["grasps"]] == [near.pose, good.pose]
    assert cell.data["grasps"][0].quality > cell.data["grasps"][1].quality
    down = dataclasses.replace(near, pose=Pose((0.35, -0.4, 0.1), (0, 1, 0, 0)))
    cell.run(cell.leaf("grasp/rank", grasps=[near, down], downward=1.0, quality=0.0))
    assert cell.data["grasps"][0].pose == down.pose


def test_counting_says_when_the_limit_is_reached(cell):
    assert cell.run(cell.leaf("flow/count")) == SUCCESS
    assert cell.data["count"] == 1
    assert cell.run(cell.leaf("flow/count", count=3, step=2, limit=5)) == ("SUCCESS", "reached", None)
    assert cell.data["count"] == 5
    assert cell.run(cell.leaf("flow/count", count=3, limit=5)) == SUCCESS


@pytest.mark.parametrize(
    ("given", "item"), [({}, "a"), ({"index": 2}, "c"), ({"index": -1}, "c"), ({"index": 3}, None)]
)
def test_selecting_takes_one_item_or_says_that_there_is_none(cell, given, item):
    leaf = cell.leaf("flow/select", items=["a", "b", "c"])
    leaf.readers.pop("index", None)
    leaf.params |= given
    expected = SUCCESS if item else ("FAILURE", "failure", "no_item")
    assert cell.run(leaf) == expected
    assert cell.data.get("item") == item


def test_waiting_for_a_condition_ends_when_it_is_true_or_the_time_is_over(cell):
    values = {"a": 1}
    leaf = cell.leaf("flow/wait_until", expression="a > 3", timeout=5.0, a=1)
    leaf.readers["a"] = lambda: values["a"]
    leaf.tick_once()
    assert leaf.status.name == "RUNNING"
    values["a"] = 4
    assert cell.run(leaf) == SUCCESS
    late = cell.leaf("flow/wait_until", expression="a > 3", timeout=0.5, a=1)
    assert cell.run(late) == ("FAILURE", "failure", "timed_out")
    with pytest.raises(Exception, match="not to true or false"):
        cell.run(cell.leaf("flow/wait_until", expression="a + 3", a=1))
