import dataclasses

import pytest
from py_trees.common import Status

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.failures import NoContactError
from grip_bt.base.values import JointState


def test_open_uses_the_named_posture(world, tick):
    assert tick(world.leaf("hand/open")) == ("SUCCESS", "success", None)
    assert world.hand.log == [("open", "open")]


def test_open_prefers_the_pre_posture_of_a_grasp(world, grasp_at):
    posture = JointState(("f",), [0.3])
    grasp = dataclasses.replace(grasp_at(), pre_posture=posture)
    world.leaf("hand/open", grasp=grasp).tick_once()
    assert world.hand.log == [("open", posture)]


def test_opening_takes_what_was_held_out_of_the_scene(world):
    world.hold()
    assert world.scene.attached("right_hand")
    world.leaf("hand/open").tick_once()
    assert not world.scene.attached("right_hand")
    assert not [n for n in world.scene.names() if n.startswith(("held_", "seen_"))]


def test_close_hands_out_the_measured_fingers(world, tick, grasp_at):
    assert tick(world.leaf("hand/close", grasp=grasp_at())) == ("SUCCESS", "success", None)
    assert world.hand.log == [("close", ("closed", 0.7))]
    assert world.data["reached"] == world.hand.state()


def test_close_takes_posture_and_torque_from_the_grasp_unless_the_task_limits_it(world, grasp_at):
    posture = JointState(("f",), [1.0])
    grasp = dataclasses.replace(grasp_at(), posture=posture, torque_limit=0.4)
    world.leaf("hand/close", grasp=grasp).tick_once()
    world.leaf("hand/close", grasp=grasp, torque_limit=0.2).tick_once()
    assert [argument for _, argument in world.hand.log] == [(posture, 0.4), (posture, 0.2)]


def test_closing_on_nothing_is_the_failure_no_contact(world, tick):
    world.hand.errors["close"].append(NoContactError("no finger touches anything"))
    assert tick(world.leaf("hand/close")) == ("FAILURE", "failure", "no_contact")


def test_a_halt_cancels_the_fingers(world):
    world.hand.held = {"close"}
    leaf = world.leaf("hand/close")
    leaf.tick_once()
    leaf.stop(Status.INVALID)
    assert ("cancel", "close") in world.hand.log


def test_a_preempt_request_stops_the_fingers(world, tick):
    world.hand.held = {"close"}
    leaf = world.leaf("hand/close")
    leaf.tick_once()
    world.context.preempt_requested = True
    tick(leaf)
    world.hand.end_canceled()
    assert tick(leaf) == ("FAILURE", "failure", "preempted")


def test_an_unknown_hand_is_found_before_the_run(world):
    with pytest.raises(UnknownNameError, match="unknown hand 'left'"):
        world.leaf("hand/open", hand="left")
