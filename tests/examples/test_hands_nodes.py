"""The nodes for any hand: grasps proposed by what a hand says of itself, and a shake.

Grasps are wide enough, off the table, and close where the thing is.
"""

from __future__ import annotations

import importlib.util
import sys
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grip_bt.base.values import Grasp, JointState, Pose, Trajectory
from grip_bt.base.values.pose import quaternion_of
from grip_bt.commanders.description.load import load_robot
from grip_bt.commanders.description.tree import joints_of_fingers
from grip_bt.commanders.hand import HandCommander
from grip_bt.commanders.kinematics.fingertips import spans_of
from grip_bt.commanders.kinematics.model import RobotModel


def loaded(name):
    file = Path(__file__).parents[2] / "examples" / "nodes" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(f"{name}_under_test", file)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


nodes, grasps = loaded("hands"), loaded("grasps")
HANDS = ("panda", "ur5_robotiq", "xarm7_gripper", "panda_allegro", "panda_allegro_left", "ur10_shadow")
LIMITS = {"approach": 0.12, "lift": 0.2, "torque_limit": 0.0}


class Fingers:
    """A port that only knows its joints."""

    def __init__(self, joints):
        self.joint_names = joints

    def state(self):
        return JointState(self.joint_names, np.zeros(len(self.joint_names)))


@cache
def hand_of(robot):
    description = load_robot(robot)
    model, states = RobotModel(description), description.named_states["hand"]
    return HandCommander(
        "hand",
        Fingers(description.group("hand")),
        states,
        joints_of_fingers(description, "hand"),
        spans=lambda postures: spans_of(model, "hand", model.grasp_frame_of("arm"), postures),
    )


def thing(width, depth, height, yaw=0.0):
    return nodes.Thing(np.array([width, depth, height]), Pose([0.5, 0.1, height / 2], quaternion_of(0, 0, yaw)))


def proposed(robot, what):
    return nodes.proposals(what, nodes.Spans.of(hand_of(robot)), LIMITS)


def lowest(span, pose):
    return float(pose.apply(span.corners)[:, 2].min())


@pytest.mark.parametrize("robot", HANDS)
@given(
    edges=st.tuples(*[st.floats(0.02, 0.09)] * 2), height=st.floats(0.03, 0.2), yaw=st.floats(-3, 3, allow_nan=False)
)
@settings(max_examples=15, deadline=None)
def test_every_hand_comes_open_wide_enough_and_above_the_table(robot, edges, height, yaw):
    spans = {span.posture.position.tobytes(): span for each in nodes.Spans.of(hand_of(robot)) for span in each}
    for grasp in proposed(robot, thing(*edges, height, yaw)):
        opened = spans[grasp.pre_posture.position.tobytes()]
        assert opened.gap >= grasp.width
        assert lowest(opened, grasp.pose) > 0
        assert np.linalg.norm(grasp.pre_grasp.position - grasp.pose.position) == pytest.approx(0.12)
        assert lowest(opened, grasp.post_grasp) == pytest.approx(lowest(opened, grasp.pose) + 0.2)


@pytest.mark.parametrize("robot", HANDS)
def test_the_tips_close_on_a_things_middle(robot):
    what = thing(0.04, 0.04, 0.08)
    down = [grasp for grasp in proposed(robot, what) if grasp.pre_grasp.position[2] > grasp.pose.position[2] + 0.1]
    found = max(down, key=lambda grasp: grasp.quality)
    held = min(nodes.Spans.of(hand_of(robot)).tips, key=lambda span: abs(span.gap - 0.04))
    met = found.pose.apply([held.middle])[0]
    assert met[:2] == pytest.approx([0.5, 0.1], abs=1e-6)
    assert 0.02 < met[2] < 0.08


@pytest.mark.parametrize("robot", HANDS)
def test_what_is_too_wide_for_a_hand_gets_no_grasp(robot):
    assert not proposed(robot, thing(0.2, 0.2, 0.1))


@pytest.mark.parametrize(("robot", "fits", "wide"), [("panda_allegro", 0.065, 0.1), ("ur10_shadow", 0.065, 0.085)])
def test_a_hand_with_a_thumb_wraps_what_fills_it_and_what_its_tips_come_around(robot, fits, wide):
    def sideways(edge):
        return [g for g in proposed(robot, thing(edge, edge, 0.18)) if abs(g.pose.rotation()[2, 2]) < 0.1]

    opened = nodes.Spans.of(hand_of(robot)).around[0]
    thumb = opened.middle - opened.gap / 2 * opened.axis
    assert sideways(fits)
    for grasp in sideways(fits):
        beside = grasp.pose.inverse().apply([[0.5, 0.1, 0.09]])[0]
        assert beside[0] - grasp.width / 2 > thumb[0], "its thumb would push the thing away as it comes"
    assert not sideways(0.02)
    assert not sideways(wide)


GRIPPERS = ("panda", "ur5_robotiq", "xarm7_gripper")


@pytest.mark.parametrize("robot", GRIPPERS)
def test_a_gripper_takes_what_is_high_from_the_side_and_what_is_low_from_above(robot):
    def best(what):
        grasp = max(proposed(robot, what), key=lambda grasp: grasp.quality)
        approach = grasp.pose.position - grasp.pre_grasp.position
        return grasp, approach / np.linalg.norm(approach)

    grasp, approach = best(thing(0.06, 0.06, 0.2))
    assert approach[2] > -0.8
    assert approach[0] > 0, "it would come towards the robot"
    assert best(thing(0.06, 0.06, 0.05))[1][2] == pytest.approx(-1)


@pytest.mark.parametrize("robot", GRIPPERS)
def test_what_was_seen_is_taken_where_it_is_heavy_and_as_narrow_as_it_is_there(robot):
    """A hammer: a thin handle along x, and a head at its end, from which the cloud sees the tops."""

    def top(x, y, z):
        grid = np.meshgrid(np.arange(*x, 0.002), np.arange(*y, 0.002))
        return np.column_stack([*(each.ravel() for each in grid), np.full(grid[0].size, z)])

    seen = np.concatenate([top((0.4, 0.57), (0.09, 0.11), 0.02), top((0.57, 0.6), (0.03, 0.17), 0.04)])
    hammer = nodes.Thing(np.array([0.2, 0.14, 0.04]), Pose([0.5, 0.1, 0.02]), seen)
    assert hammer.heavy() == pytest.approx([0.55, 0.1], abs=0.02)
    found = max(proposed(robot, hammer), key=lambda grasp: grasp.quality)
    assert found.width < 0.04
    assert found.pose.position[:2] == pytest.approx(hammer.heavy(), abs=0.04)
    assert not proposed(robot, nodes.Thing(hammer.size, hammer.pose)), "its box is too wide for the gripper"


class Reaching:
    """An arm that reaches no higher than it says, and is quick enough only below another height."""

    def __init__(self, highest, quick):
        self.there, self.highest, self.quick = Pose([0.5, 0.0, 0.3]), highest, quick

    def grasp_pose(self):
        return self.there

    async def plan_straight(self, goals):
        if goals[0].position[2] > self.highest:
            raise nodes.NoIkError("out of reach")
        way = np.array([self.there.position, goals[0].position])
        return SimpleNamespace(pose=goals[0], trajectory=Trajectory(("x", "y", "z"), [0.0, 1.0], way))

    async def plan_from_trajectory(self, way, *, slow_down):
        if way.positions[0, 2] > self.quick:
            raise nodes.OutOfLimitsError("too slow")
        return way

    async def execute(self, plan):
        self.there = plan.pose


@pytest.mark.parametrize(("highest", "quick", "begins"), [(1.0, 1.0, 0.3), (0.3, 1.0, 0.24), (1.0, 0.25, 0.24)])
def test_a_shake_begins_where_both_sides_are_in_reach_and_quickly_enough(highest, quick, begins):
    arm = Reaching(highest, quick)
    with pytest.raises(StopIteration) as ended:
        nodes._swing_in_place(arm, 0.025 * nodes.UP, (0.5, 1.0, 1.0), False).send(None)
    heights = ended.value.value.positions[:, 2]
    assert (heights[0], heights[-1]) == pytest.approx((begins, begins))
    assert (heights.min(), heights.max()) == pytest.approx((begins - 0.025, begins + 0.025), abs=1e-3)


@pytest.mark.parametrize(
    ("highest", "quick", "said"), [(0.2, 1.0, nodes.NoIkError), (1.0, 0.0, nodes.OutOfLimitsError)]
)
def test_a_shake_for_which_there_is_no_room_says_why(highest, quick, said):
    with pytest.raises(said):
        nodes._swing_in_place(Reaching(highest, quick), 0.025 * nodes.UP, (0.5, 1.0, 1.0), False).send(None)


def test_a_hand_whose_geometry_nobody_knows_says_so():
    description = load_robot("panda")
    hand = HandCommander("left_hand", Fingers(description.group("hand")), description.named_states["hand"])
    with pytest.raises(ValueError, match="left_hand.*geometry isn't known"):
        hand.spans()


@pytest.mark.parametrize("ramp", [1.0, 0.5])
def test_a_shake_goes_to_both_sides_smoothly_and_comes_back(ramp):
    names, here = ("a", "b"), np.array([0.3, -0.2])
    steps = np.linspace(0, 1, 30)[:, None]
    bent = np.column_stack([steps[:, 0] + 0.1 * steps[:, 0] ** 2, -0.5 * steps[:, 0]]) * 0.05
    forth, back = (Trajectory(names, steps[:, 0], here + sign * way) for sign, way in ((1, bent), (-1, bent)))
    way = nodes.swing(back, forth, period=0.5, seconds=1.0, ramp=ramp)
    away = way.positions - here
    assert way.duration == pytest.approx(1.0 + 2 * ramp * 0.5)
    assert (away[:, 1].min(), away[:, 1].max()) == pytest.approx((-0.025, 0.025), rel=0.03)
    assert np.abs(away[[0, -1]]).max() < 1e-9
    assert np.abs(way.velocities[[0, -1]]).max() < 1e-9
    slopes = np.gradient(way.positions, way.times, axis=0)
    assert slopes[1:-1] == pytest.approx(way.velocities[1:-1], abs=0.01)


def test_two_points_make_a_shake_too():
    forth, back = (Trajectory(("a",), [0.0, 1.0], [[0.0], [sign * 0.1]]) for sign in (1, -1))
    assert np.abs(nodes.swing(back, forth, 0.5, 1.0).positions).max() == pytest.approx(0.1, rel=0.03)


@pytest.mark.parametrize("robot", ["panda", "ur5_robotiq", "xarm7_gripper"])
@given(
    spot=st.tuples(*[st.floats(-0.1, 0.1)] * 2, st.floats(0.0, 0.3)),
    yaw=st.floats(-3, 3),
    width=st.floats(0.005, 0.12),
)
@settings(max_examples=15, deadline=None)
def test_a_grasp_of_two_fingers_is_fitted_to_whatever_gripper_there_is(robot, spot, yaw, width):
    tips = Pose((0.5, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0)).moved(spot)
    tips = Pose(tips.position, (Pose(quaternion=quaternion_of(0, 0, yaw)) @ tips).quaternion)
    said = Grasp(tips, tips.moved((0, 0, 0.12)), tips.moved((0, 0, 0.15)), width=width)
    spans = hand_of(robot).spans()
    fitted = list(grasps.fitted_to(said, spans))
    assert len(fitted) == (2 if width <= spans[0].gap else 0)
    held = [span for span in spans if span.gap >= width][-1] if fitted else spans[0]
    for grasp in fitted:
        between = grasp.pose.apply([held.middle])[0]
        np.testing.assert_allclose(between[:2], tips.position[:2], atol=1e-9)
        assert between[2] >= tips.position[2] - 1e-9
        assert abs(grasp.pose.rotation() @ held.axis @ tips.rotation()[:, 1]) > 1 - 1e-9
        np.testing.assert_allclose(grasp.pose.rotation() @ held.inward, [0, 0, -1], atol=1e-6)
        assert min(lowest(span, grasp.pose) for span in (spans[0], held)) > grasps.GAP - 1e-9
        np.testing.assert_allclose(grasp.pre_grasp.position - grasp.pose.position, (0, 0, 0.12), atol=1e-9)
