import numpy as np
import pytest
from py_trees.common import Status

from grip_bt.base.failures import CanceledError, ExecutionAbortedError, NoContactError, PathInvalidError
from grip_bt.base.values import Pose
from grip_bt.nodes.grasping import same_grasp

# --- choose and remember ---


def test_choose_takes_the_best_feasible_grasp(world, tick, grasp_at):
    low, high = grasp_at(quality=0.1), grasp_at(approach=1.0, quality=0.9)
    assert tick(world.leaf("grasp/choose", grasps=[low, high])) == ("SUCCESS", "success", None)
    assert world.data["grasp"] is high


@pytest.mark.parametrize(
    ("centre", "approach", "same"),
    [((0.5, 0.1), 0.0, True), ((0.51, 0.1), 0.1, True), ((0.53, 0.1), 0.0, False), ((0.5, 0.1), 0.5, False)],
)
def test_grasps_within_2_cm_and_20_degrees_are_the_same(grasp_at, centre, approach, same):
    assert same_grasp(grasp_at(), grasp_at(centre, approach)) is same


def test_the_same_place_with_the_hand_turned_over_is_another_grasp(grasp_at):
    grasp = grasp_at()
    turned = Pose(grasp.pose.position, (grasp.pose @ Pose([0, 0, 0], [0, 0, 0, 1])).quaternion)
    other = type(grasp)(turned, turned, turned)
    assert not same_grasp(grasp, other)


def test_choose_leaves_out_what_was_tried(world, tick, grasp_at):
    best, second = grasp_at(quality=0.9), grasp_at(approach=1.0, quality=0.1)
    nearly_best = grasp_at((0.505, 0.1))
    leaf = world.leaf("grasp/choose", grasps=[best, second], tried=[nearly_best])
    assert tick(leaf) == ("SUCCESS", "success", None)
    assert world.data["grasp"] is second


def test_choose_fails_with_no_grasp_and_says_why(world, tick, grasp_at):
    assert tick(world.leaf("grasp/choose", grasps=[])) == ("FAILURE", "failure", "no_grasp")
    leaf = world.leaf("grasp/choose", grasps=[grasp_at()], tried=[grasp_at()])
    assert tick(leaf) == ("FAILURE", "failure", "no_grasp")
    assert "tried before" in leaf.failure.message
    world.arm.feasible = lambda grasp: False
    leaf = world.leaf("grasp/choose", grasps=[grasp_at()])
    assert tick(leaf) == ("FAILURE", "failure", "no_grasp")
    assert leaf.failure.data["reasons"] == {"no_ik": 1}
    assert "grasp" not in world.data


def test_remember_writes_a_longer_list_and_leaves_the_old_one_alone(world, tick, grasp_at):
    old = [grasp_at()]
    new = grasp_at(approach=1.0)
    assert tick(world.leaf("grasp/remember", grasp=new, tried=old)) == ("SUCCESS", "success", None)
    assert world.data["tried"] == [old[0], new]
    assert len(old) == 1


# --- approach ---


def test_the_approach_plans_freely_to_the_pre_grasp_and_then_goes_straight(world, tick, grasp_at):
    grasp = grasp_at()
    assert tick(world.leaf("arm/move_to_grasp", grasp=grasp)) == ("SUCCESS", "success", None)
    assert world.arm.verbs() == ["plan", "execute", "straight", "execute"]
    assert world.arm.log[0][1] == grasp.pre_grasp
    assert world.arm.pose == grasp.pose


def test_only_the_straight_part_of_the_approach_may_touch_the_object_and_only_that_one(world, grasp_at):
    world.stand("seen_0", (0.5, 0.1))
    world.stand("seen_1", (0.5, 0.3))
    before, seen = world.scene.box("seen_0"), []
    world.arm.on_plan = lambda verb, goal: seen.append((verb, [n for n in world.scene.names() if n[:4] == "seen"]))
    world.leaf("arm/move_to_grasp", grasp=grasp_at()).tick_once()
    assert seen == [("plan", ["seen_0", "seen_1"]), ("straight", ["seen_1"])]
    assert np.array_equal(world.scene.box("seen_0")[0], before[0])
    assert world.scene.box("seen_0")[1] == before[1]


def test_the_object_is_back_in_the_scene_when_the_straight_part_has_no_plan(world, tick, grasp_at):
    world.stand()
    world.arm.errors["straight"].append(PathInvalidError("blocked"))
    assert tick(world.leaf("arm/move_to_grasp", grasp=grasp_at())) == ("FAILURE", "failure", "path_invalid")
    assert "seen_0" in world.scene.names()


def test_the_object_is_back_in_the_scene_when_planning_is_canceled(world, grasp_at):
    world.stand()
    world.arm.held = {"straight"}
    leaf = world.leaf("arm/move_to_grasp", grasp=grasp_at())
    leaf.tick_once()
    assert "seen_0" not in world.scene.names()
    leaf.stop(Status.INVALID)
    world.arm.end_canceled()
    assert "seen_0" in world.scene.names()
    assert "execute" not in world.arm.verbs()[2:]


# --- lift ---


def test_lift_attaches_the_object_and_goes_straight_up(world, tick, grasp_at):
    grasp = grasp_at()
    world.stand()
    world.arm.pose = grasp.pose
    assert tick(world.leaf("arm/lift", grasp=grasp)) == ("SUCCESS", "success", None)
    assert world.arm.log[0] == ("straight", [grasp.post_grasp])
    (held,) = world.scene.attached("right_hand")
    assert world.scene.box(held)[1].position[2] == pytest.approx(0.0815 + 0.15, abs=1e-6)
    assert "seen_0" not in world.scene.names()


def test_lift_goes_up_all_the_same_when_the_scene_has_nothing_there(world, tick, grasp_at):
    world.stand(centre=(0.5, 0.3))
    assert tick(world.leaf("arm/lift", grasp=grasp_at())) == ("SUCCESS", "success", None)
    assert not world.scene.attached("right_hand")


def test_a_lift_that_is_blocked_fails_with_its_reason(world, tick, grasp_at):
    world.arm.errors["straight"].append(PathInvalidError("blocked"))
    assert tick(world.leaf("arm/lift", grasp=grasp_at())) == ("FAILURE", "failure", "path_invalid")


# --- retreat ---


def test_retreat_opens_backs_off_along_the_palm_and_goes_up(world, tick, grasp_at):
    grasp = grasp_at()
    world.arm.pose = grasp.pose
    assert tick(world.leaf("arm/retreat")) == ("SUCCESS", "success", None)
    assert world.hand.verbs() == ["open"]
    np.testing.assert_allclose(world.arm.pose.position, grasp.pose.position + [-0.12, 0, 0.1], atol=1e-9)


def test_retreat_takes_shorter_steps_where_the_whole_one_is_blocked(world, tick, grasp_at):
    grasp = grasp_at()
    world.arm.pose = grasp.pose
    world.arm.errors["straight"].extend([PathInvalidError("blocked")] * 2)
    assert tick(world.leaf("arm/retreat")) == ("SUCCESS", "success", None)
    np.testing.assert_allclose(world.arm.pose.position, grasp.pose.position + [-0.03, 0, 0.1], atol=1e-9)


def test_retreat_goes_up_when_it_cannot_go_back_and_goes_on_when_the_hand_does_not_open(world, tick, grasp_at):
    world.arm.pose = grasp_at().pose
    world.hand.errors["open"].append(NoContactError("stuck"))
    world.arm.errors["straight"].extend([PathInvalidError("blocked")] * 3)
    assert tick(world.leaf("arm/retreat")) == ("SUCCESS", "success", None)
    np.testing.assert_allclose(world.arm.pose.position, grasp_at().pose.position + [0, 0, 0.1], atol=1e-9)


def test_retreat_is_stuck_only_when_no_step_can_be_made(world, tick, grasp_at):
    world.arm.pose = grasp_at().pose
    world.arm.errors["straight"].extend([PathInvalidError("blocked")] * 5 + [ExecutionAbortedError("slipped")])
    world.arm.errors["execute"].append(ExecutionAbortedError("slipped"))
    leaf = world.leaf("arm/retreat")
    assert tick(leaf) == ("FAILURE", "failure", "stuck")
    assert len(leaf.failure.data["reasons"]) == 2


def test_retreat_ignores_what_the_hand_is_among_and_nothing_else(world, grasp_at):
    world.stand("seen_0", (0.5, 0.1))
    world.stand("seen_1", (0.6, -0.1))
    world.arm.pose = grasp_at().pose
    seen = []
    world.arm.on_plan = lambda verb, goal: seen.append([n for n in world.scene.names() if n[:4] == "seen"])
    world.leaf("arm/retreat").tick_once()
    assert seen[0] == ["seen_1"]
    assert {"seen_0", "seen_1"} <= set(world.scene.names())


def test_what_a_retreating_hand_held_stands_below_it_in_the_scene(world):
    world.hold()
    world.leaf("arm/retreat").tick_once()
    assert not world.scene.attached("right_hand")
    (name,) = (n for n in world.scene.names() if n.startswith("seen_"))
    size, pose = world.scene.box(name)
    np.testing.assert_allclose(pose.position, [0.5, 0.1, size[2] / 2 + 0.003], atol=1e-9)


def test_a_canceled_step_ends_the_retreat(world, tick, grasp_at):
    world.arm.errors["execute"].append(CanceledError("canceled"))
    assert tick(world.leaf("arm/retreat")) == ("FAILURE", "failure", "canceled")
    assert world.arm.verbs() == ["straight", "execute"]
