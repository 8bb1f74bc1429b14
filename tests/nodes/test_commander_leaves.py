"""Leaves over the shipped fakes of an arm and a hand: plans as values, jogging, following, teaching, fingers."""

from __future__ import annotations

import numpy as np
import pytest
from cell import CLOSED, OPEN, SUCCESS, Cell
from timed import TimedArm

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import ExecutionAbortedError, NoIkError, OutOfLimitsError, PathInvalidError, SensorError
from grip_bt.base.values import JointState, Pose, Trajectory

BRAKING = 1.0
"""A fake is at rest so long after it was told to stop [s]."""


@pytest.fixture
def cell(world):
    return Cell(world)


# --- plans ---


def test_a_plan_is_a_value_that_moves_nothing_until_it_is_followed(cell):
    before, goal = cell.arm.grasp_pose(), Pose((0.5, 0.1, 0.3))
    assert cell.run(cell.leaf("arm/plan", goal=goal)) == SUCCESS
    assert cell.arm.grasp_pose() == before
    assert cell.run(cell.leaf("arm/execute", plan=cell.data["plan"])) == SUCCESS
    assert cell.arm.grasp_pose().position == pytest.approx(goal.position)
    assert cell.data["reached"].position[:3] == pytest.approx(goal.position)


def test_a_plan_begins_where_it_is_told_and_is_refused_elsewhere(cell):
    start = JointState(cell.arm.state().names, [0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    assert cell.run(cell.leaf("arm/plan", state="home", start=start)) == SUCCESS
    plan = cell.data["plan"]
    assert plan.trajectory.positions[0].tolist() == start.position.tolist()
    assert cell.run(cell.leaf("arm/execute", plan=plan)) == ("FAILURE", "failure", "aborted")


def test_a_plan_needs_one_goal_and_a_known_one_and_says_so_before_the_run(cell):
    with pytest.raises(ValueError, match="either"):
        cell.leaf("arm/plan")
    with pytest.raises(ValueError, match="either"):
        cell.leaf("arm/plan", state="home", goal=Pose())
    with pytest.raises(UnknownNameError, match="home"):
        cell.leaf("arm/plan", state="hoem")


@pytest.mark.parametrize(("node", "verb"), [("arm/plan", "plan"), ("arm/plan_straight", "plan_straight")])
def test_a_plan_that_fails_says_why(world, node, verb):
    cell = Cell(world, **{verb: [NoIkError("too far")]})
    given = {"goal": Pose()} if node == "arm/plan" else {"poses": [Pose()]}
    assert cell.run(cell.leaf(node, **given)) == ("FAILURE", "failure", "no_ik")


def test_straight_lines_go_through_their_corners(cell):
    corners = [cell.arm.grasp_pose().moved(way) for way in ((0.1, 0, 0), (0.1, 0.1, 0))]
    assert cell.run(cell.leaf("arm/plan_straight", poses=corners)) == SUCCESS
    assert len(cell.data["plan"].trajectory.times) == 3


def test_a_stored_trajectory_is_gone_to_and_followed(cell):
    given = Trajectory(("x", "y"), [0.0, 1.0, 2.0], [[0.5, 0.0], [0.5, 0.2], [0.3, 0.2]])
    assert cell.run(cell.leaf("arm/execute_trajectory", trajectory=given)) == SUCCESS
    assert cell.data["reached"].position == pytest.approx([0.3, 0.2, 0.5, 0.0, 0.0, 0.0])
    point = Trajectory(("z",), [0.0], [[0.7]])
    assert cell.run(cell.leaf("arm/execute_trajectory", trajectory=point)) == SUCCESS
    assert cell.arm.grasp_pose().position == pytest.approx([0.3, 0.2, 0.7])


def test_a_trajectory_that_begins_elsewhere_is_refused_when_the_arm_may_not_go_there_first(cell):
    given = Trajectory(("x", "y"), [0.0, 1.0], [[0.5, 0.0], [0.5, 0.2]])
    before = cell.arm.grasp_pose()
    leaf = cell.leaf("arm/execute_trajectory", trajectory=given, approach=False)
    assert cell.run(leaf) == ("FAILURE", "failure", "aborted")
    assert cell.arm.grasp_pose() == before


@pytest.mark.parametrize("error", [OutOfLimitsError("too fast"), PathInvalidError("a touches b")])
def test_a_trajectory_that_cannot_be_followed_moves_nothing_and_says_why(world, error):
    cell = Cell(world, plan_from_trajectory=[error])
    before = cell.arm.grasp_pose()
    given = Trajectory(("x",), [0.0, 1.0], [[0.5], [0.6]])
    leaf = cell.leaf("arm/execute_trajectory", trajectory=given)
    assert cell.run(leaf) == ("FAILURE", "failure", error.code)
    assert cell.arm.grasp_pose() == before


def test_arms_move_together_by_their_plans(cell):
    other = TimedArm("left", Pose((0.3, 0.4, 0.5)), cell.schedule)
    arms = {"right": cell.arm, "left": other}
    cell.world.context.arm = lambda name: arms[name]
    plans = [arm.plan(arm.grasp_pose().moved((0, 0, up))).result() for arm, up in ((cell.arm, 0.2), (other, 0.4))]
    assert cell.run(cell.leaf("arm/execute_together", arms=["right", "left"], plans=plans)) == SUCCESS
    right, left = cell.data["reached"]
    assert (right.position[2], left.position[2]) == (pytest.approx(0.7), pytest.approx(0.9))
    failed = cell.run(cell.leaf("arm/execute_together", arms=["right", "left"], plans=plans[:1]))
    assert failed == ("FAILURE", "failure", "path_invalid")
    with pytest.raises(ValueError, match="once"):
        cell.leaf("arm/execute_together", arms=["right", "right"], plans=plans)


def test_moving_to_joints_and_straight_by_an_offset(cell):
    joints = JointState(cell.arm.state().names, [0.2, 0.1, 0.4, 0.0, 0.0, 0.3])
    assert cell.run(cell.leaf("arm/move_to_joints", state=joints)) == SUCCESS
    assert cell.data["reached"].position.tolist() == joints.position.tolist()
    assert cell.run(cell.leaf("arm/move_straight", offset=[0.0, 0.0, 0.1])) == SUCCESS
    assert cell.arm.grasp_pose().position == pytest.approx([0.2, 0.1, 0.5])
    assert cell.run(cell.leaf("arm/move_straight", pose=Pose((0.2, 0.2, 0.5)))) == SUCCESS
    assert cell.arm.grasp_pose().position == pytest.approx([0.2, 0.2, 0.5])
    with pytest.raises(ValueError, match="either"):
        cell.leaf("arm/move_straight")
    with pytest.raises(ValueError, match="3 lengths"):
        cell.leaf("arm/move_straight", offset=[1.0])


def test_a_pose_may_leave_its_orientation_open(cell):
    assert cell.run(cell.leaf("arm/move_to_pose", pose=Pose((0.4, 0, 0.4)), free="orientation")) == SUCCESS
    with pytest.raises(Exception, match="orientation"):
        cell.run(cell.leaf("arm/move_to_pose", pose=Pose((0.4, 0, 0.4)), free="yaw"))


# --- jogging, following, holding ---


def test_jogging_moves_with_the_twist_for_its_time(cell):
    leaf = cell.leaf("arm/jog", linear=[0.0, 0.0, -0.1], angular=[0.0, 0.0, 0.5], seconds=1.0)
    assert cell.run(leaf) == SUCCESS
    assert cell.arm.grasp_pose().position == pytest.approx([0.3, -0.4, 0.4])
    assert cell.data["reached"].position[5] == pytest.approx(0.5)
    assert cell.clock.now() == pytest.approx(1.0, abs=0.11)


def test_an_interrupted_jog_holds(cell):
    leaf = cell.leaf("arm/jog", linear=[0.0, 0.0, -0.1], seconds=1.0)
    leaf.tick_once()
    cell.clock.advance(0.5)
    leaf.stop()
    cell.clock.advance(BRAKING)
    held = cell.arm.grasp_pose()
    cell.clock.advance(1.0)
    assert cell.arm.grasp_pose() == held
    assert 0.4 < held.position[2] < 0.5


def test_following_catches_a_target_that_moves_away_meanwhile(cell):
    target = [Pose((0.3, -0.4, 0.6))]
    leaf = cell.leaf("arm/follow", pose=target[0])
    leaf.readers["pose"] = lambda: target[0]
    for _ in range(4):
        leaf.tick_once()
        cell.clock.advance(0.2)
    target[0] = Pose((0.5, -0.4, 0.6), (np.cos(0.2), 0, 0, np.sin(0.2)))
    assert cell.run(leaf) == SUCCESS
    assert cell.data["reached"].position == pytest.approx([0.5, -0.4, 0.6], abs=0.011)
    # 0.1 m and then 0.2 m at no more than 0.15 m/s
    assert cell.clock.now() >= 0.2 / 0.15


def test_following_may_go_on_at_the_target_until_it_is_asked_to_end(cell):
    leaf = cell.leaf("arm/follow", pose=cell.arm.grasp_pose(), keep_on=True)
    for _ in range(3):
        leaf.tick_once()
        cell.clock.advance(0.2)
    assert leaf.status.name == "RUNNING"
    cell.world.context.preempt_requested = True
    assert cell.run(leaf) == ("FAILURE", "failure", "preempted")


def test_a_target_out_of_reach_ends_the_following(world):
    cell = Cell(world, plan_step=[None, PathInvalidError("in the way")])
    leaf = cell.leaf("arm/follow", pose=Pose((0.3, -0.4, 0.9)))
    assert cell.run(leaf) == ("FAILURE", "failure", "path_invalid")
    stood = cell.arm.grasp_pose()
    assert 0.51 < stood.position[2] < 0.6, "what was free was gone"
    cell.clock.advance(1.0)
    assert cell.arm.grasp_pose() == stood


def speeds(cell, leaf, seconds):
    """How fast the grasp frame moves from tick to tick, every 0.05 s [m/s]."""
    places = []
    for _ in range(round(seconds / 0.05)):
        leaf.tick_once()
        places.append(cell.arm.grasp_pose().position)
        cell.clock.advance(0.05)
    return np.linalg.norm(np.diff(places, axis=0), axis=1) / 0.05


def test_following_does_not_stop_between_its_steps(cell):
    leaf = cell.leaf("arm/follow", pose=Pose((0.9, -0.4, 0.5)), speed=0.2)
    seen = speeds(cell, leaf, 2.5)
    assert seen.max() <= 0.2 + 1e-6
    assert seen[3:].min() > 0.19
    assert leaf.status.name == "RUNNING"


def test_jogging_without_an_end_goes_on_until_it_is_interrupted(cell):
    leaf = cell.leaf("arm/jog", linear=[0.1, 0.0, 0.0], angular=[0.0, 0.0, 0.2], seconds=None)
    assert speeds(cell, leaf, 3.0)[3:].tolist() == pytest.approx([0.1] * 56, abs=1e-3)
    leaf.stop()
    cell.clock.advance(BRAKING)
    held = cell.arm.grasp_pose()
    cell.clock.advance(1.0)
    assert cell.arm.grasp_pose() == held


def test_who_asks_no_more_lets_the_arm_come_to_rest(cell):
    leaf = cell.leaf("arm/jog", linear=[0.2, 0.0, 0.0], seconds=None)
    speeds(cell, leaf, 1.0)
    begin = cell.arm.grasp_pose().position
    cell.clock.advance(0.6)
    rest = cell.arm.grasp_pose()
    assert 0.0 < np.linalg.norm(rest.position - begin) < 0.2 * 0.6
    cell.clock.advance(1.0)
    assert cell.arm.grasp_pose() == rest
    leaf.tick_once()
    leaf.tick_once()
    cell.clock.advance(0.2)
    assert cell.arm.grasp_pose() != rest, "and goes on when it is asked again"


def test_holding_ends_a_motion_and_lasts_as_long_as_it_should(cell):
    moving = cell.arm.plan(Pose((0.9, 0, 0.5))).then(cell.arm.execute)
    cell.clock.advance(0.2)
    leaf = cell.leaf("arm/hold", seconds=1.0)
    assert cell.run(leaf) == SUCCESS
    assert moving.done()
    assert cell.clock.now() == pytest.approx(1.2, abs=0.11)
    forever = cell.leaf("arm/hold", seconds=None)
    for _ in range(20):
        forever.tick_once()
        cell.clock.advance(10)
    assert forever.status.name == "RUNNING"


def test_an_arm_that_is_held_has_come_to_rest(cell):
    cell.arm.plan(Pose((0.9, 0, 0.5))).then(cell.arm.execute)
    cell.clock.advance(0.5)
    leaf = cell.leaf("arm/hold")
    leaf.tick_once()
    assert leaf.status.name == "RUNNING"
    assert cell.run(leaf, step=0.02) == SUCCESS
    before = cell.arm.state().position
    cell.clock.advance(1.0)
    assert cell.arm.state().position == pytest.approx(before, abs=1e-6)


@pytest.mark.parametrize("part", ["arm", "hand"])
def test_where_nothing_is_measured_nobody_says_that_it_rests(cell, monkeypatch, part):
    joints, silent = getattr(cell, part), True
    measured = joints.state

    def state():
        if silent:
            raise SensorError("nothing is heard of the joints")
        return measured()

    monkeypatch.setattr(joints, "state", state)
    leaf = cell.leaf(f"{part}/hold")
    for _ in range(20):
        leaf.tick_once()
        cell.clock.advance(0.5)
    assert leaf.status.name == "RUNNING"
    silent = False
    assert cell.run(leaf) == SUCCESS


def test_where_the_arm_is_can_be_read(cell):
    assert cell.run(cell.leaf("arm/read_state")) == SUCCESS
    assert cell.run(cell.leaf("arm/read_pose")) == SUCCESS
    assert cell.data["state"].names == cell.arm.state().names
    assert cell.data["pose"] == cell.arm.grasp_pose()


def test_where_the_fingers_are_can_be_read(cell):
    assert cell.run(cell.leaf("hand/read_state")) == SUCCESS
    assert cell.data["state"].as_mapping() == cell.hand.state().as_mapping()
    assert cell.data["forces"] == {}


def test_how_hard_the_hand_presses_can_be_read(cell):
    cell.port.thing = JointState(OPEN.names, [0.5, 0.5])
    cell.run(cell.leaf("hand/close", force=3.0))
    cell.run(cell.leaf("hand/read_state"))
    assert cell.data["forces"] == {"fingertip": 3.0}


# --- teaching ---


def test_what_was_taught_is_gone_to_again(cell):
    cell.run(cell.leaf("arm/move_to_pose", pose=Pose((0.6, 0.1, 0.3))))
    assert cell.run(cell.leaf("arm/teach", name="shelf")) == SUCCESS
    assert cell.run(cell.leaf("arm/teach", name="shelf_pose", pose=True)) == SUCCESS
    assert cell.data["value"] == cell.arm.grasp_pose()
    for name in ("shelf", "shelf_pose"):
        cell.run(cell.leaf("arm/move_to", state="home"))
        assert cell.run(cell.leaf("arm/move_to_taught", name=name)) == SUCCESS
        assert cell.arm.grasp_pose().position == pytest.approx([0.6, 0.1, 0.3])


def test_what_was_not_taught_lists_what_was_and_a_state_of_the_robot_is_not_replaced(cell):
    cell.arm.teach("shelf")
    leaf = cell.leaf("arm/move_to_taught", name="shlef")
    assert cell.run(leaf) == ("FAILURE", "failure", "not_taught")
    assert leaf.failure.data["taught"] == ["shelf"]
    assert cell.run(cell.leaf("arm/teach", name="home")) == ("FAILURE", "failure", "name_taken")
    assert cell.run(cell.leaf("hand/teach", name="open")) == ("FAILURE", "failure", "name_taken")
    with pytest.raises(ValueError, match="word"):
        cell.leaf("arm/teach", name="over there")


# --- the hand ---


def test_fingers_go_to_postures_named_bound_and_taught(cell):
    assert cell.run(cell.leaf("hand/posture", posture="closed", torque_limit=0.2, seconds=2.0)) == SUCCESS
    assert cell.port.torque_limits == [0.2]
    assert cell.clock.now() == pytest.approx(2.0, abs=0.11)
    assert cell.run(cell.leaf("hand/posture", state=JointState(("thumb",), [0.3]))) == SUCCESS
    assert cell.data["reached"].as_mapping() == pytest.approx({"finger": 1.0, "thumb": 0.3})
    cell.run(cell.leaf("hand/teach", name="pinch"))
    cell.run(cell.leaf("hand/open"))
    assert cell.run(cell.leaf("hand/posture", posture="pinch")) == SUCCESS
    assert cell.data["reached"].as_mapping() == pytest.approx({"finger": 1.0, "thumb": 0.3})
    assert cell.run(cell.leaf("hand/posture", posture="pinhc")) == ("FAILURE", "failure", "not_taught")
    with pytest.raises(ValueError, match="either"):
        cell.leaf("hand/posture")


def test_single_fingers_and_synergies(cell):
    assert cell.run(cell.leaf("hand/fingers", closing={"thumb": 0.4})) == SUCCESS
    assert cell.data["reached"].as_mapping() == pytest.approx({"finger": 0.0, "thumb": 0.4})
    assert cell.run(cell.leaf("hand/synergy", weights=[1.0])) == SUCCESS
    assert cell.data["reached"].position == pytest.approx([1.0, 1.0])
    assert cell.run(cell.leaf("hand/synergy", weights=[])) == SUCCESS
    assert cell.data["reached"].position == pytest.approx([0.5, 0.5])
    with pytest.raises(UnknownNameError, match="finger, thumb"):
        cell.leaf("hand/fingers", closing={"tumb": 0.4})
    with pytest.raises(ValueError, match="at most 1"):
        cell.leaf("hand/synergy", weights=[1.0, 1.0])


def test_a_grasp_is_watched_until_contact_is_lost_for_longer_than_a_moment(cell):
    cell.port.thing = JointState(OPEN.names, [0.5, 0.5])
    assert cell.run(cell.leaf("hand/has_contact")) == ("FAILURE", "failure", "no_contact")
    cell.run(cell.leaf("hand/close"))
    assert cell.run(cell.leaf("hand/has_contact")) == SUCCESS
    assert cell.data["links"] == ["fingertip"]
    watch = cell.leaf("hand/keep_contact", patience=0.3)
    thing = cell.port.thing
    for gone in (False, True, False, False):
        cell.port.thing = None if gone else thing
        watch.tick_once()
        assert watch.status.name == "RUNNING"
        cell.clock.advance(0.2)
    cell.port.thing = None
    begun = cell.clock.now()
    assert cell.run(watch) == ("FAILURE", "failure", "lost_contact")
    assert cell.clock.now() - begun == pytest.approx(0.3, abs=0.11)


def test_a_grasp_is_watched_until_something_slips(cell):
    cell.port.thing = JointState(OPEN.names, [0.5, 0.5])
    cell.run(cell.leaf("hand/close"))
    cell.run(cell.leaf("hand/read_state"))
    assert cell.data["pressing"] == sum(cell.data["forces"].values()) / 2 > 0
    assert cell.run(cell.leaf("hand/watch_slip", seconds=0.1)) == SUCCESS
    watch = cell.leaf("hand/watch_slip")
    for speed in (0.0, 0.004):
        cell.port.slipping = speed
        watch.tick_once()
        assert watch.status.name == "RUNNING"
        cell.clock.advance(0.1)
    cell.port.slipping = 0.02
    assert cell.run(watch) == ("FAILURE", "failure", "slipped")
    assert cell.data["speeds"] == {"fingertip": 0.02}


def test_a_wrist_is_read_and_compared_with_before(cell):
    cell.arm.load = np.array([0.0, 0, -1.0, 0, 0, 0])
    assert cell.run(cell.leaf("arm/read_wrench")) == SUCCESS
    before = cell.data["wrench"]
    cell.arm.load = np.array([0.0, 0, -3.0, 0, 0, 0])
    assert cell.run(cell.leaf("arm/read_wrench", zero=before)) == SUCCESS
    assert cell.data["wrench"] == [0.0, 0, -2.0, 0, 0, 0]


def test_what_no_sensor_measures_is_said(cell):
    cell.arm._wrench = cell.hand._touch = None
    assert cell.run(cell.leaf("arm/read_wrench")) == ("FAILURE", "failure", "no_data")
    assert cell.run(cell.leaf("hand/watch_slip")) == ("FAILURE", "failure", "no_data")


def test_weak_or_few_contacts_may_not_count(cell):
    cell.port.thing = JointState(OPEN.names, [0.5, 0.5])
    cell.run(cell.leaf("hand/close"))
    assert cell.run(cell.leaf("hand/has_contact", links=2)) == ("FAILURE", "failure", "no_contact")
    assert cell.run(cell.leaf("hand/has_contact", force=100.0)) == ("FAILURE", "failure", "no_contact")


def test_holding_a_hand_ends_its_motion(cell):
    moving = cell.hand.close()
    cell.clock.advance(0.3)
    leaf = cell.leaf("hand/hold")
    leaf.tick_once()
    assert leaf.status.name == "RUNNING"
    assert cell.run(leaf, step=0.02) == SUCCESS
    assert moving.done()
    before = cell.hand.state().position
    cell.clock.advance(1.0)
    assert cell.hand.state().position == pytest.approx(before, abs=1e-6)


def test_an_aborted_motion_is_named_whatever_leaf_asked_for_it(world):
    for node, given in (
        ("arm/move_to_joints", {"state": JointState(("x", "y", "z", "rx", "ry", "rz"), [0.1] * 6)}),
        ("arm/move_straight", {"offset": [0.1, 0.0, 0.0]}),
        ("arm/jog", {"linear": [0.1, 0.0, 0.0]}),
        ("arm/move_to_taught", {"name": "there"}),
    ):
        cell = Cell(world, execute=[ExecutionAbortedError("stuck")])
        cell.arm._taught.put("right", "there", Pose((0.5, 0.0, 0.5)), {})
        assert cell.run(cell.leaf(node, **given)) == ("FAILURE", "failure", "aborted"), node


# --- fingertips ---


def placing(cell, far=None):
    def reach(targets, posture, frame):
        cell.asked = (dict(targets), frame)
        if far:
            raise NoIkError("the hand can't reach these", distances=far)
        return CLOSED

    cell.hand._reach = reach
    return cell


def test_fingertips_go_where_the_hand_finds_a_posture_for_them(cell):
    leaf = placing(cell).leaf("hand/fingertips", tips={"thumb": [0.0, 0.0, 0.1]}, frame="palm")
    assert cell.run(leaf) == SUCCESS
    assert cell.asked == ({"thumb": [0.0, 0.0, 0.1]}, "palm")
    assert cell.hand.state().position == pytest.approx(CLOSED.position)
    assert cell.run(cell.leaf("hand/fingertips", targets={"finger": [0.0, 0.1, 0.0]})) == SUCCESS
    assert cell.asked == ({"finger": [0.0, 0.1, 0.0]}, "")


def test_fingertips_out_of_reach_are_the_failure_no_ik(cell):
    leaf = placing(cell, far={"thumb": 0.2}).leaf("hand/fingertips", tips={"thumb": [0.0, 0.0, 0.5]})
    assert cell.run(leaf) == ("FAILURE", "failure", "no_ik")
    assert leaf.failure.data["distances"] == {"thumb": 0.2}


def test_fingertips_are_said_once(cell):
    with pytest.raises(ValueError, match="either `with: {tips: ...}` or `in: {targets: ...}`"):
        cell.leaf("hand/fingertips", tips={"thumb": [0.0, 0.0, 0.1]}, targets={"thumb": [0.0, 0.0, 0.1]})


def test_a_hand_refuses_positions_that_are_none(cell):
    with pytest.raises(ValueError, match="3 finite numbers"):
        cell.hand.fingertip_posture({"thumb": [0.0, float("nan"), 0.0]})
    with pytest.raises(ValueError, match="geometry isn't known"):
        cell.hand.fingertip_posture({"thumb": [0.0, 0.0, 0.0]})
