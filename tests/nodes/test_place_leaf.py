import numpy as np
import pytest
from py_trees.common import Status

from grip_bt.base.failures import NoPlanError, PathInvalidError
from grip_bt.base.values import Pose

LOW, HIGH = np.array([0.35, -0.55]), np.array([0.61, -0.25])


def placed(world):
    return [n for n in world.scene.names() if n.startswith("placed_")]


def test_the_object_ends_upright_within_the_target_and_the_hand_above_it(world, tick):
    world.hold()
    leaf = world.leaf("arm/place", target="crate")
    assert tick(leaf) == ("SUCCESS", "success", None)
    size, pose = world.scene.box("placed_0")
    np.testing.assert_allclose(pose.rotation()[:, 2], [0, 0, 1], atol=1e-6)
    assert pose.position[2] == pytest.approx(size[2] / 2 + 0.003)
    assert np.all(pose.position[:2] - 0.03 > LOW)
    assert np.all(pose.position[:2] + 0.03 < HIGH)
    assert not world.scene.attached("right_hand")


def test_it_comes_from_above_lets_go_just_above_the_floor_and_leaves_upward(world):
    world.hold()
    world.leaf("arm/place", target="crate").tick_once()
    verbs = [v for v in world.arm.verbs() if v != "choose"]
    assert verbs == ["plan", "execute", "straight", "execute", "straight", "execute"]
    above, release, leave = (goal for verb, goal in world.arm.log if verb in ("plan", "straight"))
    assert above.position[2] - release[-1].position[2] >= 0.16, "the hand ends above the object that it leaves"
    np.testing.assert_allclose(above.position[:2], release[-1].position[:2], atol=1e-9)
    np.testing.assert_allclose(leave[-1].position, above.position, atol=1e-9)
    # The palm was 9 cm above the table when it took the object, so its foot is 2 cm above the floor now.
    assert 0.107 - 0.02 <= release[-1].position[2] <= 0.16
    assert world.hand.verbs() == ["open"]


def test_three_objects_find_room_and_keep_away_from_each_other(world, tick):
    for _ in range(3):
        world.hold(radius=0.034, height=0.17)
        assert tick(world.leaf("arm/place", target="crate")) == ("SUCCESS", "success", None)
        world.arm.pose = Pose([0.3, 0, 0.6])
    spots = [world.scene.box(n)[1].position[:2] for n in placed(world)]
    assert len(spots) == 3
    gaps = [np.linalg.norm(a - b) - 0.068 for i, a in enumerate(spots) for b in spots[:i]]
    assert min(gaps) > 0.03


def test_a_given_position_is_used_with_and_without_a_target(world, tick):
    for target in ("crate", ""):
        world.hold()
        leaf = world.leaf("arm/place", target=target, position=[0.5, -0.4])
        assert tick(leaf) == ("SUCCESS", "success", None)
        size, pose = world.scene.box("placed_0")
        np.testing.assert_allclose(pose.position[:2], [0.5, -0.4], atol=1e-6)
        world.scene.remove("placed_0")


def test_nothing_held_is_a_failure_before_anything_moves(world, tick):
    assert tick(world.leaf("arm/place", target="crate")) == ("FAILURE", "failure", "nothing_held")
    assert world.arm.log == []


def test_an_unknown_target_is_a_failure_that_says_what_there_is(world, tick):
    world.hold()
    leaf = world.leaf("arm/place", target="basket")
    assert tick(leaf) == ("FAILURE", "failure", "no_target")
    assert "basket_*" in leaf.failure.message
    assert "crate_left" in leaf.failure.message


def test_a_full_target_is_the_failure_no_room(world, tick):
    world.hold()
    world.scene.set_box("placed_0", [0.2, 0.24, 0.15], Pose([0.48, -0.4, 0.08]))
    assert tick(world.leaf("arm/place", target="crate")) == ("FAILURE", "failure", "no_room")


def test_spots_out_of_reach_are_the_failure_no_room_with_the_arms_reasons(world, tick):
    world.hold()
    world.arm.feasible = lambda grasp: False
    leaf = world.leaf("arm/place", target="crate")
    assert tick(leaf) == ("FAILURE", "failure", "no_room")
    assert set(leaf.failure.data["reasons"]) == {"no_ik"}
    assert world.scene.attached("right_hand"), "it still holds the object"


def test_another_spot_is_tried_when_the_first_has_no_plan(world, tick):
    world.hold()
    world.arm.errors["plan"].append(NoPlanError("no"))
    world.arm.errors["straight"].append(PathInvalidError("no"))
    assert tick(world.leaf("arm/place", target="crate")) == ("SUCCESS", "success", None)
    goals = [goal for verb, goal in world.arm.log if verb == "plan"]
    assert len(goals) == 3
    assert goals[0] != goals[1] != goals[2]


def test_after_four_spots_without_a_plan_it_gives_up_still_holding(world, tick):
    world.hold()
    world.arm.errors["plan"].extend([NoPlanError("no")] * 9)
    assert tick(world.leaf("arm/place", target="crate")) == ("FAILURE", "failure", "no_plan")
    assert world.arm.verbs().count("plan") == 4
    assert world.hand.log == []


def test_leaving_goes_back_first_where_up_is_blocked(world, tick):
    world.hold()
    world.arm.errors["straight"].extend([None, PathInvalidError("blocked")])
    assert tick(world.leaf("arm/place", target="crate")) == ("SUCCESS", "success", None)
    _, up, back_and_up = (goal for verb, goal in world.arm.log if verb == "straight")
    assert len(up) == 1
    assert len(back_and_up) == 2
    assert back_and_up[0].position[2] < up[0].position[2] - 0.15


def test_leaving_half_closes_the_hand_where_open_fingers_are_caught(world, tick):
    world.hold()
    world.arm.errors["straight"].extend([None, *[PathInvalidError("a finger touches a wall")] * 3])
    assert tick(world.leaf("arm/place", target="crate")) == ("SUCCESS", "success", None)
    assert [argument for _, argument in world.hand.log] == ["open", world.hand.state()]
    assert world.arm.verbs()[-2:] == ["straight", "execute"]


def test_an_arm_that_cannot_leave_at_all_is_a_failure_but_the_object_is_placed(world, tick):
    world.hold()
    world.arm.errors["straight"].extend([None, *[PathInvalidError("blocked")] * 6])
    assert tick(world.leaf("arm/place", target="crate")) == ("FAILURE", "failure", "path_invalid")
    assert placed(world) == ["placed_0"]
    assert not world.scene.attached("right_hand")


def test_a_spot_has_to_be_free_with_open_fingers_and_with_fingers_as_they_hold(world, tick):
    world.hold()
    refused = []

    def feasible(grasp):
        fine = grasp.pre_posture is None or len(refused) == 5
        if not fine:
            refused.append(grasp)
        return fine

    world.arm.feasible = feasible
    assert tick(world.leaf("arm/place", target="crate")) == ("SUCCESS", "success", None)
    assert world.arm.verbs().count("plan") == 1, "nothing moves before a spot is found"
    assert all(grasp.pre_posture == world.hand.state() for grasp in refused)
    assert len({tuple(grasp.pose.matrix().ravel()) for grasp in refused}) == 5


def test_a_halt_on_the_way_cancels_the_motion_and_keeps_the_object_attached(world):
    world.hold()
    world.arm.held = {"execute"}
    leaf = world.leaf("arm/place", target="crate")
    leaf.tick_once()
    leaf.stop(Status.INVALID)
    world.arm.end_canceled()
    assert world.arm.log[-1] == ("cancel", "execute")
    assert world.scene.attached("right_hand")
    assert world.hand.log == []


def test_a_preempt_request_on_the_way_is_the_failure_preempted(world, tick):
    world.hold()
    world.arm.held = {"execute"}
    leaf = world.leaf("arm/place", target="crate")
    leaf.tick_once()
    world.context.preempt_requested = True
    tick(leaf)
    world.arm.end_canceled()
    assert tick(leaf) == ("FAILURE", "failure", "preempted")
    assert world.hand.log == []


def test_a_spot_is_preferred_that_stays_free_if_what_stands_there_is_a_little_elsewhere(world, tick):
    world.hold()
    assert tick(world.leaf("arm/place", target="crate")) == ("SUCCESS", "success", None)
    before = world.scene.box("placed_0")[0]
    world.hold()
    seen = []

    def feasible(grasp):
        seen.append(world.scene.box("placed_0")[0][:2] - before[:2])
        return True

    world.arm.feasible = feasible
    assert tick(world.leaf("arm/place", target="crate")) == ("SUCCESS", "success", None)
    np.testing.assert_allclose(seen, 0.04)  # 2 cm to each side
    np.testing.assert_allclose(world.scene.box("placed_0")[0], before)


def test_where_no_spot_has_so_much_room_a_tight_one_is_taken(world, tick):
    world.hold()
    assert tick(world.leaf("arm/place", target="crate")) == ("SUCCESS", "success", None)
    before = world.scene.box("placed_0")[0]
    world.hold()
    world.arm.feasible = lambda grasp: bool(np.allclose(world.scene.box("placed_0")[0], before))
    assert tick(world.leaf("arm/place", target="crate")) == ("SUCCESS", "success", None)
    assert placed(world) == ["placed_0", "placed_1"]
