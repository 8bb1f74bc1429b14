"""What the referee says about situations that were really brought about."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from sim_bench import ABOVE, ASIDE, AT, SPOT

from grip_bt.base.values import Pose
from grip_bt.commanders.description.load import load_robot
from grip_sim.referee import judge
from grip_sim.specs import ObjectSpec, WorldSpec

pytestmark = pytest.mark.sim
LYING = [np.sqrt(0.5), 0, np.sqrt(0.5), 0]


Contact = pytest.importorskip("grip_sim.world").Contact


def put(bench, pose, settle=0.6):
    bench.referee.move_object("thing", pose)
    bench.simulation.settle(settle)
    return bench.truth()


def test_what_stands_on_the_table_is_standing(bench):
    truth = bench.truth()
    assert truth.status == "standing"
    assert truth.hand_force == 0
    assert truth.pose.position == pytest.approx(ASIDE.position, abs=2e-3)


def test_what_lies_on_the_table_is_lying(bench):
    assert put(bench, Pose([0.9, 0.45, 0.031], LYING), 1.0).status == "lying"


def test_what_is_in_the_crate_is_placed_however_it_lies(bench):
    assert put(bench, Pose([0.48, -0.40, 0.09])).status == "placed"
    assert put(bench, Pose([0.48, -0.40, 0.031], LYING), 1.0).status == "placed"


def test_what_is_beside_the_crate_is_not_placed(bench):
    assert put(bench, Pose([0.70, -0.40, 0.09])).status == "standing"


def test_what_is_below_the_table_has_fallen(bench):
    assert put(bench, Pose([1.2, 0.0, 0.1]), 1.0).status == "fallen"


def test_what_falls_is_elsewhere_until_it_lies(bench):
    assert put(bench, Pose([0.9, 0.45, 0.6]), 0.1).status == "elsewhere"


def test_what_was_grasped_and_lifted_is_held_and_stays_so(bench):
    bench.grasp()
    truth = bench.truth()
    assert truth.status == "held"
    assert truth.hand_force > 1
    height = truth.pose.position[2]
    assert height > SPOT.position[2] + 0.08
    bench.simulation.settle(2.0)
    later = bench.truth()
    assert later.status == "held"
    assert later.pose.position[2] == pytest.approx(height, abs=2e-3)  # friction keeps it from slipping


def test_what_is_grasped_but_still_on_the_table_is_not_held(bench):
    bench.go(AT)
    bench.referee.move_object("thing", SPOT)
    bench.wait(bench.hand.move(bench.opened, 0.3))
    bench.wait(bench.hand.move(bench.closed, 1.2, 0.05))
    truth = bench.truth()
    assert truth.hand_force > 0
    assert truth.status == "elsewhere"


def test_what_is_held_stays_held_when_something_beside_touches_it(bench):
    bench.grasp()
    thing = bench.truth().pose
    bench.referee.move_object("other", thing.moved([0.0, 0.0, 0.09 + 0.0605]))  # on top of it: it bears nothing
    bench.simulation.settle(0.15)
    assert bench.truth("other").pose.position[2] > thing.position[2] + 0.14
    assert bench.truth().status == "held"


def test_what_another_object_bears_is_not_held_by_a_hand_that_touches_it(bench):
    bench.go(ABOVE)
    foot = Pose([*SPOT.position[:2], 0.06])
    bench.referee.move_object("other", foot)
    bench.referee.move_object("thing", foot.moved([0, 0, 0.06 + 0.09]))
    bench.wait(bench.hand.move(bench.closed, 1.2, 0.02))
    truth = bench.truth()
    assert truth.hand_force > 0
    assert truth.pose.position[2] == pytest.approx(0.21, abs=5e-3)
    assert truth.status == "elsewhere"


def test_what_was_let_go_is_not_held(bench):
    bench.grasp()
    bench.wait(bench.hand.move(bench.opened, 0.5))
    bench.simulation.settle(1.0)
    assert bench.truth().status != "held"
    assert bench.truth().pose.position[2] < 0.12


def test_what_was_just_moved_out_of_the_hand_is_not_held_any_more(bench):
    bench.grasp()
    bench.referee.move_object("thing", ASIDE)
    truth = bench.truth()
    assert truth.hand_force == 0
    assert truth.status == "standing"


def test_a_palm_is_of_the_hand_though_no_joint_of_the_hand_moves_it():
    """As the Shadow hand's is: what it bears is held, what somebody else bears isn't."""
    spec = WorldSpec(objects=(ObjectSpec("thing", "cylinder", 0.03, 0.1, (0.0, 0.0, 0.5)),))
    robot = load_robot("shadow_right")
    assert robot.grasp_frame.link not in robot.hand_links
    for bearer, status in (("rh_palm", "held"), ("rh_forearm", "elsewhere")):
        touched = [Contact("thing", bearer, (0.0, 0.0, 2.0)), Contact("thing", "rh_ffdistal", (-1.0, 0.0, 0.0))]
        world = SimpleNamespace(
            spec=spec,
            contacts=lambda touched=touched: touched,
            robot=SimpleNamespace(hand_links=frozenset(robot.hand_links), description=robot),
            object_pose=lambda name: spec.objects[0].pose,
            object_speeds=lambda name: (0.0, 0.0),
        )
        (truth,) = judge(world)
        assert truth.status == status
