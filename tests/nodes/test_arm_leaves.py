import pytest
from py_trees.common import Status

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import (
    ExecutionAbortedError,
    GoalInCollisionError,
    NoIkError,
    NoPlanError,
    PathInvalidError,
    StartInCollisionError,
    TimeOutError,
)
from grip_bt.base.values import Pose

EXPECTED = [
    ("plan", StartInCollisionError),
    ("plan", GoalInCollisionError),
    ("plan", NoIkError),
    ("plan", NoPlanError),
    ("plan", PathInvalidError),
    ("plan", TimeOutError),
    ("execute", ExecutionAbortedError),
]


def test_move_to_plans_then_follows_and_hands_out_what_was_measured(world, tick):
    leaf = world.leaf("arm/move_to", arm="right", state="home")
    assert tick(leaf) == ("SUCCESS", "success", None)
    assert world.arm.log == [("plan", "home"), ("execute", "home")]
    assert world.data["reached"] == world.arm.state()


def test_move_to_pose_goes_to_the_pose_it_reads(world, tick):
    goal = Pose([0.5, 0.2, 0.4])
    leaf = world.leaf("arm/move_to_pose", pose=goal)
    assert tick(leaf) == ("SUCCESS", "success", None)
    assert world.arm.pose == goal


@pytest.mark.parametrize(("verb", "error"), EXPECTED, ids=[e.code for _, e in EXPECTED])
def test_expected_trouble_is_a_failure_with_its_code_message_and_data(world, tick, verb, error):
    world.arm.errors[verb].append(error("because", code="odd", pairs=["a", "b"]))
    leaf = world.leaf("arm/move_to_pose", pose=Pose([0.5, 0.2, 0.4]))
    assert tick(leaf) == ("FAILURE", "failure", error.code)
    assert leaf.failure.message == "because"
    assert leaf.failure.data == {"code": "odd", "pairs": ["a", "b"]}
    assert error.code in leaf.manifest.codes


def test_an_unknown_arm_or_state_is_found_before_the_run_and_the_error_names_the_node(world):
    with pytest.raises(UnknownNameError, match="left.*right"):
        world.leaf("arm/move_to", arm="left", state="home")
    with pytest.raises(UnknownNameError, match="task/leaf.*hom.*did you mean 'home'"):
        world.leaf("arm/move_to", state="hom")


def test_a_bug_in_an_adapter_is_no_failure_but_an_error(world):
    world.arm.errors["plan"].append(ZeroDivisionError("oops"))
    with pytest.raises(Exception, match="task/leaf: ZeroDivisionError"):
        world.leaf("arm/move_to", state="home").tick_once()


def test_a_waiting_leaf_is_woken_by_the_end_of_its_motion_and_never_polls(world, tick):
    world.arm.held = {"plan", "execute"}
    leaf = world.leaf("arm/move_to", state="home")
    assert tick(leaf)[0] == "RUNNING"
    world.arm.finish()
    assert world.context.wakes == 0, "the plan is only half of the work"
    world.arm.finish()
    assert world.context.wakes == 1
    assert world.context.alarms == []
    assert tick(leaf) == ("SUCCESS", "success", None)
    assert world.arm.verbs() == ["plan", "execute"]


@pytest.mark.parametrize("part", ["plan", "execute"])
def test_a_halt_cancels_the_part_that_is_under_way_once(world, part):
    world.arm.held = {part}
    leaf = world.leaf("arm/move_to", state="home")
    leaf.tick_once()
    leaf.stop(Status.INVALID)
    leaf.stop(Status.INVALID)
    assert world.arm.log.count(("cancel", part)) == 1
    assert leaf.outcome is None


def test_after_a_halt_the_next_activation_starts_anew(world, tick):
    world.arm.held = {"execute"}
    leaf = world.leaf("arm/move_to", state="home")
    leaf.tick_once()
    leaf.stop(Status.INVALID)
    world.arm.held = set()
    assert tick(leaf) == ("SUCCESS", "success", None)
    assert world.arm.verbs().count("plan") == 2


def test_a_preempt_request_stops_the_motion_and_the_leaf_ends_when_the_arm_has_stopped(world, tick):
    world.arm.held = {"execute"}
    leaf = world.leaf("arm/move_to", state="home")
    leaf.tick_once()
    world.context.preempt_requested = True
    assert tick(leaf)[0] == "RUNNING"
    assert tick(leaf)[0] == "RUNNING"
    assert world.arm.log.count(("cancel", "execute")) == 1
    world.arm.end_canceled()
    assert tick(leaf) == ("FAILURE", "failure", "preempted")


def test_a_motion_that_ends_before_it_could_be_preempted_counts(world, tick):
    world.arm.held = {"execute"}
    leaf = world.leaf("arm/move_to", state="home")
    leaf.tick_once()
    world.context.preempt_requested = True
    tick(leaf)
    world.arm.finish()
    assert tick(leaf) == ("SUCCESS", "success", None)


def test_recovery_runs_while_a_preempt_request_stands(world, tick):
    world.context.preempt_requested = True
    world.arm.held = {"execute"}
    leaf = world.leaf("arm/move_to", state="home")
    assert tick(leaf)[0] == "RUNNING"
    assert tick(leaf)[0] == "RUNNING"
    assert ("cancel", "execute") not in world.arm.log


def test_a_motion_that_somebody_else_canceled_is_no_preemption(world, tick):
    world.arm.held = {"execute"}
    leaf = world.leaf("arm/move_to", state="home")
    leaf.tick_once()
    world.arm.end_canceled()
    assert tick(leaf) == ("FAILURE", "failure", "canceled")
