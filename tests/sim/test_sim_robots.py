"""Ready-made robots in the physics: they stand where they rest, and fingers that follow others do."""

import numpy as np
import pytest

from grip_bt.commanders.description.load import load_robot
from grip_sim.specs import WorldSpec

pytestmark = pytest.mark.sim
pytest.importorskip("sapien")


@pytest.mark.parametrize("name", ["panda", "xarm7", "ur10_shadow", "shadow_left", "two_ur5_allegro"])
def test_a_ready_made_robot_stands_still_where_it_rests(name):
    from grip_sim.world import World

    world = World(WorldSpec(robot=name))
    before = world.robot.positions()
    for _ in range(60):
        world.step()
    assert np.abs(world.robot.positions() - before).max() < 0.01
    rest = load_robot(name).at_rest
    driven = world.robot.measure(world.robot.rows(tuple(rest)))
    assert driven.position == pytest.approx(list(rest.values()), abs=0.01)


def test_the_second_finger_of_a_gripper_follows_the_first():
    from grip_sim.world import World

    world = World(WorldSpec(robot="panda"))
    world.robot.drive(world.robot.group_rows("hand"), np.array([0.01]))
    for _ in range(120):
        world.step()
    fingers = world.robot.measure(world.robot.rows(("panda_finger_joint1", "panda_finger_joint2")))
    assert fingers.position == pytest.approx([0.01, 0.01], abs=1e-3)
