"""Leaves that go through way points, over the shipped fake arm: what they take, refuse and hand out."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from timed import ManualClock, OnClock, TimedArm

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import NoIkError, PathInvalidError
from grip_bt.base.values import PathConstraint, Pose, WayPoint
from grip_bt.task import loads
from grip_bt.task.catalog import Catalog
from grip_bt.task.validation import validate

OFFSETS = [[0.1, 0.0, 0.0], [0.1, 0.1, 0.0], [0.0, 0.1, 0.0]]


class Asked(TimedArm):
    """A fake arm that remembers the way points that it was asked for."""

    asked: tuple[WayPoint, ...] = ()
    constraint = None

    def plan_through(self, way_points, *, start=None, constraint=None):
        self.asked, self.constraint = tuple(way_points), constraint
        return super().plan_through(way_points, start=start, constraint=constraint)


def cell(world, **script):
    clock = ManualClock()
    world.context._arm = Asked("right", Pose((0.3, -0.4, 0.5)), OnClock(clock), script=script)
    world.context.clock = clock
    return world


def end_of(world, leaf):
    for _ in range(200):
        leaf.tick_once()
        if leaf.outcome is not None:
            return leaf.outcome, leaf.failure and leaf.failure.code
        world.context.clock.advance(0.1)
    raise AssertionError("it still runs after 20 s")


def test_offsets_are_way_points_from_where_the_hand_is_with_one_radius_for_the_inner_ones(world):
    arm = cell(world).context._arm
    begin = arm.grasp_pose()
    assert end_of(world, world.leaf("arm/move_through", offsets=OFFSETS, radius=0.03)) == ("success", None)
    assert [point.goal for point in arm.asked] == [begin.moved(offset) for offset in OFFSETS]
    assert [point.radius for point in arm.asked] == [0.03, 0.03, 0.0]
    assert arm.grasp_pose().position == pytest.approx(begin.moved(OFFSETS[-1]).position)
    assert world.data["reached"].position[:3] == pytest.approx(arm.grasp_pose().position)
    assert world.data["radii"] == [0.0, 0.0]  # fakes go through the points themselves


def test_bound_way_points_have_radii_of_their_own_and_may_be_states_and_joints(world):
    arm = cell(world).context._arm
    there = arm.grasp_pose().moved([0.2, 0, 0])
    points = ["home", arm.state(), WayPoint(there, 0.2, straight=False)]
    leaf = world.leaf("arm/plan_through", way_points=points, radii=[0.1, 0.0], straight=False)
    assert end_of(world, leaf) == ("success", None)
    assert [point.radius for point in arm.asked] == [0.1, 0.0, 0.2]
    assert not any(point.straight for point in arm.asked)
    assert world.data["plan"].trajectory.positions[-1][:3] == pytest.approx(there.position)
    assert arm.grasp_pose().position == pytest.approx([0.3, -0.4, 0.5])  # nothing has moved


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "give either"),
        ({"offsets": OFFSETS, "way_points": [Pose()]}, "give either"),
        ({"offsets": [[0.1, 0.0]]}, "3 lengths"),
        ({"offsets": OFFSETS, "radius": -0.1}, "blend radius is a length"),
        ({"offsets": OFFSETS, "radii": [0.1, -0.1]}, "blend radius is a length"),
        ({"offsets": OFFSETS, "radii": [0.1]}, "3 way points have 2 inner ones, and there are 1 radii"),
    ],
)
def test_what_makes_no_sense_is_refused_before_the_run(world, given, words):
    cell(world)
    with pytest.raises(ValueError, match=words):
        world.leaf("arm/move_through", **given)


def test_way_points_that_turn_out_wrong_are_failures_that_say_why(world):
    cell(world)
    leaf = world.leaf("arm/move_through", way_points=[Pose()] * 3, radii=[0.1])
    assert end_of(world, leaf) == ("failure", "path_invalid")
    assert "2 inner ones" in leaf.failure.message
    assert end_of(world, world.leaf("arm/move_through", way_points=[])) == ("failure", "path_invalid")


@pytest.mark.parametrize("error", [NoIkError("too far"), PathInvalidError("a touches b")])
def test_a_way_that_cannot_be_planned_says_why(world, error):
    cell(world, plan_through=[error])
    assert end_of(world, world.leaf("arm/plan_through", offsets=OFFSETS)) == ("failure", error.code)


def test_an_unknown_state_among_the_way_points_is_named(world):
    arm = cell(world).context._arm
    with pytest.raises(UnknownNameError, match="home"):
        arm.plan_through([WayPoint("hoem")])
    with pytest.raises(ValueError, match="at least one"):
        arm.plan_through([])


def test_what_the_page_shows_is_right(world):
    page = (Path(__file__).parents[2] / "docs" / "motion.md").read_text()
    section = page.split("## Way points and blends")[1].split("\n## ")[0]
    (task,), (code,) = (re.findall(rf"```{language}\n(.*?)```", section, re.DOTALL) for language in ("yaml", "python"))
    assert validate(loads(task), Catalog.builtin()).issues == ()
    names = {}
    exec(compile(code, "docs/motion.md", "exec"), names)
    arm = cell(world).context._arm
    with pytest.raises(UnknownNameError, match="look"):
        names["over_the_wall"](arm, Pose(), Pose())
    arm.teach("look")
    assert names["over_the_wall"](arm, Pose(), Pose([1.0, 0, 0])).trajectory.positions[-1][0] == pytest.approx(1.0)


@pytest.mark.parametrize("node", ["arm/plan_through", "arm/move_through"])
def test_the_whole_way_keeps_to_what_is_said_or_bound(world, node):
    arm = cell(world).context._arm
    level = PathConstraint(Pose(quaternion=arm.grasp_pose().quaternion))
    assert end_of(world, world.leaf(node, offsets=OFFSETS, keep={"orientation": "now"})) == ("success", None)
    assert arm.constraint == level
    box = PathConstraint(box=Pose((0, 0, 3)), size=(0.1, 0.1, 0.1))
    assert end_of(world, world.leaf(node, offsets=OFFSETS, constraint=box)) == ("failure", "constraint_broken")
    assert arm.constraint == box
    with pytest.raises(ValueError, match="either `with: {keep: ...}` or `in: {constraint: ...}`"):
        world.leaf(node, offsets=OFFSETS, keep={"orientation": "now"}, constraint=box)
