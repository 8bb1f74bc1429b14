"""Two arms in one scene: what either holds is in the other's way, and motions at once are checked as one."""

from __future__ import annotations

import numpy as np
import pytest
from robot_files import SRDF, urdf
from timed import ManualClock, OnClock, TimedExecutor

from grip_bt.base.failures import OutOfLimitsError, PathInvalidError
from grip_bt.base.operation import Operation
from grip_bt.base.values import JointState, Plan, Pose, Trajectory
from grip_bt.base.values.solids import Box
from grip_bt.commanders.arm import ArmCommander, ArmSetup
from grip_bt.commanders.description.config import RobotConfig
from grip_bt.commanders.description.load import load_robot
from grip_bt.commanders.joined import execute_together
from grip_bt.commanders.kinematics.collision import CollisionChecker
from grip_bt.commanders.kinematics.model import RobotModel
from grip_bt.commanders.planning.answer import answer
from grip_bt.commanders.planning.requests import CheckTogether, Situation
from grip_bt.commanders.scene_state import HandMount, SceneObject, SceneSnapshot
from grip_bt.commanders.settings import PlanningSettings
from grip_bt.commanders.trajectory.splines import eased

UPRIGHT = np.zeros(6)
SIDES = ("left", "right")


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    """Two small arms, 1 m high when upright, 0.8 m apart."""
    folder = tmp_path_factory.mktemp("pair")
    (folder / "smally.urdf").write_text(urdf())
    (folder / "smally.srdf").write_text(SRDF)
    one = {"urdf": "smally.urdf", "srdf": "smally.srdf"}
    config = {
        "name": "pair",
        "robots": {"left": {"robot": one, "xyz": [0, 0.4, 0]}, "right": {"robot": one, "xyz": [0, -0.4, 0]}},
        "groups": {"arms": {"groups": ["left_manipulator", "right_manipulator"]}},
    }
    return RobotModel(load_robot(RobotConfig.model_validate(config), folder))


@pytest.fixture
def carriers(model):
    hands = model.description.hands
    return {f"{side}_hand": HandMount(f"{side}_manipulator", frozenset(hands[f"{side}_gripper"])) for side in SIDES}


def at(model, side, q=UPRIGHT):
    return JointState(model.description.group(f"{side}_manipulator"), q)


def pole(hand, length=1.7):
    """A pole across the hand that holds it, along the y axis of the grasp frame."""
    return SceneObject("pole", Box((0.06, length, 0.06)), Pose((0, 0, 0.14)), hand=hand)


def names(pairs):
    return {name for pair in pairs for name in pair}


def test_what_the_other_hand_holds_is_in_the_way(model, carriers):
    chain = model.chain("left_manipulator", at(model, "right"))
    empty = SceneSnapshot({}, carriers=carriers)
    assert not CollisionChecker(chain, empty, "left_hand").pairs(UPRIGHT)
    held = empty.with_object(pole("right_hand"))
    touching = CollisionChecker(chain, held, "left_hand").pairs(UPRIGHT)
    assert "pole" in names(touching)
    assert all(name.startswith("left_") for name in names(touching) - {"pole"}), "its own hand may touch it"
    assert not CollisionChecker(chain, empty.with_object(pole("right_hand", 0.7)), "left_hand").pairs(UPRIGHT)


def test_it_is_where_the_other_arm_is(model, carriers):
    held = SceneSnapshot({}, carriers=carriers).with_object(pole("right_hand"))
    turned = at(model, "right", [np.pi / 2, 0, 0, 0, 0, 0])
    assert not CollisionChecker(model.chain("left_manipulator", turned), held, "left_hand").pairs(UPRIGHT)


def test_what_is_held_meets_the_other_arm_and_what_that_holds(model, carriers):
    empty = SceneSnapshot({}, carriers=carriers)
    chain = model.chain("left_manipulator", at(model, "right"))
    touching = CollisionChecker(chain, empty.with_object(pole("left_hand")), "left_hand").pairs(UPRIGHT)
    assert any(name.startswith("right_") for name in names(touching))
    other = SceneObject("bar", Box((0.06, 0.9, 0.06)), Pose((0, 0, 0.14)), hand="right_hand")
    both = empty.with_object(pole("left_hand", 0.9)).with_object(other)
    assert set(CollisionChecker(chain, both, "left_hand").pairs(UPRIGHT)) in ({("pole", "bar")}, {("bar", "pole")})
    joined = model.joined_chain(["left_manipulator", "right_manipulator"])
    assert names(CollisionChecker(joined, both).pairs(np.zeros(12))) == {"pole", "bar"}


def plan(model, side, end, seconds=2.0):
    joints = model.description.group(f"{side}_manipulator")
    return Plan(f"{side}_manipulator", eased(joints, UPRIGHT, np.array(end), seconds), "test")


def in_and_out(model, side, begin):
    """Three seconds inward and three back, beginning at a time [s]; at rest before and after."""
    joints = model.description.group(f"{side}_manipulator")
    rows = [UPRIGHT, UPRIGHT, np.array(HALF_IN[side]), UPRIGHT, UPRIGHT]
    times = [0.0, begin + 0.01, begin + 3.0, begin + 6.0, 15.0]
    return Plan(f"{side}_manipulator", Trajectory(joints, times, rows, np.zeros((5, 6))), "test")


HALF_IN = {"left": [-np.pi / 2, 0.7, 0, 0, 0, 0], "right": [np.pi / 2, 0.7, 0, 0, 0, 0]}
"""Each hand is a little past the middle then."""


INWARD = {"left": [-np.pi / 2, 1.2, 0, 0, 0, 0], "right": [np.pi / 2, 1.2, 0, 0, 0, 0]}


def situation(model, carriers):
    start = at(model, "left")
    return Situation(
        "left_manipulator",
        start,
        SceneSnapshot({}, carriers=carriers),
        "left_hand",
        PlanningSettings(planning_time=600.0),
    )


def test_motions_that_meet_on_the_way_are_refused_with_when_and_what(model, carriers):
    plans = tuple(plan(model, side, INWARD[side]) for side in SIDES)
    with pytest.raises(PathInvalidError, match=r"after \d\.\d s of the common motion, .* touches") as caught:
        answer(model, CheckTogether(situation(model, carriers), plans), lambda: False)
    assert 0.5 < caught.value.data["time"] < 2.0
    assert {name.split("_")[0] for name in names(caught.value.data["pairs"])} == {"left", "right"}


def test_motions_one_after_the_other_are_fine_where_the_same_at_once_are_not(model, carriers):
    apart = (in_and_out(model, "left", 0.0), in_and_out(model, "right", 7.5))
    assert answer(model, CheckTogether(situation(model, carriers), apart), lambda: False) is None
    at_once = (in_and_out(model, "left", 0.0), in_and_out(model, "right", 0.0))
    with pytest.raises(PathInvalidError):
        answer(model, CheckTogether(situation(model, carriers), at_once), lambda: False)


def swinging(model, side, speed):
    """A little inward in a second, a second there, and back; with a speed at the inner points, in and out again."""
    joints = model.description.group(f"{side}_manipulator")
    rows, velocities = np.zeros((4, 6)), np.zeros((4, 6))
    rows[:, 0], rows[:, 1], velocities[:, 1] = HALF_IN[side][0], [0.0, 0.2, 0.2, 0.0], [0.0, speed, -speed, 0.0]
    return Plan(f"{side}_manipulator", Trajectory(joints, [0.0, 1.0, 2.0, 3.0], rows, velocities), "test")


def test_arms_are_looked_at_where_controllers_bring_them_between_the_points_of_their_plans(model, carriers):
    """Both stand a little inward from the first to the second point, or go in and out: the points are the same."""
    asked = situation(model, carriers)
    still = tuple(swinging(model, side, 0.0) for side in SIDES)
    assert answer(model, CheckTogether(asked, still), lambda: False) is None
    swung = tuple(swinging(model, side, 1.2) for side in SIDES)
    with pytest.raises(PathInvalidError, match="common motion") as caught:
        answer(model, CheckTogether(asked, swung), lambda: False)
    assert 1.0 < caught.value.data["time"] < 2.0
    assert {name.split("_")[0] for name in names(caught.value.data["pairs"])} == {"left", "right"}
    one = (swung[0], still[1])
    assert answer(model, CheckTogether(asked, one), lambda: False) is None, "one alone doesn't reach the other"


def test_two_plans_for_one_joint_are_refused(model, carriers):
    twice = (plan(model, "left", UPRIGHT), plan(model, "left", UPRIGHT))
    with pytest.raises(ValueError, match="the same joint"):
        answer(model, CheckTogether(situation(model, carriers), twice), lambda: False)


class InProcess:
    """Answers at once, and keeps what it was asked."""

    def __init__(self, model):
        self.model, self.asked = model, []

    def submit(self, request):
        self.asked.append(request)
        try:
            return Operation.finished(answer(self.model, request, lambda: False))
        except Exception as error:  # noqa: BLE001 - the caller raises it
            return Operation.failed(error)


@pytest.fixture
def arms(model, carriers):
    clock, planner = ManualClock(), InProcess(model)

    class Scene:
        def snapshot(self):
            return SceneSnapshot({}, carriers=carriers)

    executors = {side: TimedExecutor(at(model, side), OnClock(clock)) for side in SIDES}
    made = {
        side: ArmCommander(
            ArmSetup(side, f"{side}_manipulator", f"{side}_hand", PlanningSettings(planning_time=600.0)),
            model,
            planner,
            executors[side],
            Scene(),
            lambda other=other: [executors[other].state()],
        )
        for side, other in zip(SIDES, reversed(SIDES), strict=True)
    }
    return made, clock, planner


def test_arms_that_would_meet_do_not_begin(model, arms):
    made, clock, _ = arms
    together = execute_together({side: (made[side], plan(model, side, INWARD[side])) for side in SIDES})
    clock.advance(5)
    with pytest.raises(PathInvalidError, match="common motion"):
        together.result()
    for side in SIDES:
        assert made[side].state().position == pytest.approx(UPRIGHT)


def test_no_arm_begins_when_the_plan_of_another_is_beyond_its_limits(model, arms):
    made, clock, _ = arms
    ends = {"left": UPRIGHT + 0.1, "right": np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])}
    together = execute_together({side: (made[side], plan(model, side, ends[side], 0.5)) for side in SIDES})
    clock.advance(5)
    with pytest.raises(OutOfLimitsError, match="of right_j6 = "):
        together.result()
    for side in SIDES:
        assert made[side].state().position == pytest.approx(UPRIGHT)


def test_plans_are_stretched_before_they_are_checked(model, arms):
    made, clock, planner = arms
    plans = {"left": plan(model, "left", HALF_IN["left"], 8.0), "right": plan(model, "right", UPRIGHT + 0.1, 1.0)}
    together = execute_together({side: (made[side], plans[side]) for side in SIDES})
    clock.advance(8.1)
    assert together.result()["right"].position == pytest.approx(UPRIGHT + 0.1)
    assert [p.trajectory.duration for p in planner.asked[-1].plans] == pytest.approx([8.0, 8.0])


def test_an_arm_is_planned_round_where_the_other_is_now(model, arms):
    made, clock, planner = arms
    moving = made["right"].execute(plan(model, "right", INWARD["right"], 3.0))
    clock.advance(3.1)
    assert moving.result()
    with pytest.raises(PathInvalidError):
        made["left"].plan_straight(
            [made["left"].grasp_pose().moved((0, 0, -0.01))], start=at(model, "left", INWARD["left"])
        ).result()
    start = planner.asked[-1].situation.start.as_mapping()
    assert start["right_j2"] == pytest.approx(1.2)
