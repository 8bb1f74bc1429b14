"""A hand presses with the force that it is told, and lets slip what that can't hold."""

import numpy as np
import pytest

from grip_bt.commanders.description.load import load_robot

pytestmark = pytest.mark.sim
pytest.importorskip("sapien")


def held(friction, force, name="panda", mass=0.2, stand=False):
    """Return a world whose gripper holds a box in the air with a force, and its finger's row."""
    from grip_bt.commanders.kinematics.model import RobotModel
    from grip_sim.motions import MoveHand
    from grip_sim.specs import BoxSpec, ObjectSpec, WorldSpec
    from grip_sim.world import World

    robot = load_robot(name)
    tcp = RobotModel(robot).grasp_pose(group="arm")
    yaw = float(np.arctan2(*tcp.rotation()[1::-1, 1]))
    x, y, z = (float(c) for c in tcp.position)
    thing = ObjectSpec("thing", "box", 0.015, 0.05, (x, y, z - 0.01), yaw, mass, friction=friction)
    below = BoxSpec("stand", (0.01, 0.01, 0.05), (x, y, z - 0.06), (90, 90, 90))
    world = World(WorldSpec(robot=name, objects=(thing,), boxes=(below,) if stand else ()))
    rows = world.robot.rows(world.robot.description.group("hand"))
    begin, closed = world.object_pose("thing"), robot.named_state("hand", "closed").position[:1]
    world.robot.press(rows, force)
    motion = MoveHand(world.robot, rows, np.array(closed), 0.5, 0.0, force)
    while motion.advance(world) is None:
        world.step()
        if not stand and world.pressed("hand") < 1.2 * mass * 9.81 / (2 * friction):
            world.move_object("thing", begin)  # until it is held
    return world, rows


def run(world, seconds):
    """Step, and return how hard the hand pressed at each step [N]."""
    found = []
    for _ in range(round(seconds / world.spec.dt)):
        world.step()
        found.append(world.pressed("hand"))
    return np.array(found)


@pytest.mark.parametrize("name", ["panda", "ur5_gripper", "ur5_robotiq", "xarm7_gripper"])
@pytest.mark.parametrize("force", [3.0, 8.0, 12.0])
def test_a_gripper_presses_with_the_force_that_it_is_told(name, force):
    world, _ = held(0.5, force, name, stand=True)
    run(world, 0.5)
    assert run(world, 1.0).mean() == pytest.approx(force, rel=0.05)


@pytest.mark.parametrize("force", [5.0, 10.0, 20.0])
@pytest.mark.parametrize("name", ["ur5_robotiq", "xarm7_gripper"])
def test_a_linkage_that_meets_a_thing_holds_it_in_the_air(name, force):
    world, _ = held(0.5, force, name)
    begin = world.object_pose("thing").position[2]
    forces = run(world, 1.0)
    assert forces.mean() == pytest.approx(force, rel=0.05)
    assert forces.std() < 0.1 * force
    assert abs(world.object_pose("thing").position[2] - begin) < 1e-4


@pytest.mark.parametrize("mass", [0.2, 0.5])
@pytest.mark.parametrize("friction", [0.3, 0.5, 0.8])
@pytest.mark.parametrize("name", ["panda", "ur5_gripper"])
def test_what_two_fingers_hold_slips_at_half_its_weight_over_the_friction(name, friction, mass):
    """Coulomb: two pads carry 2 mu F. The force sinks by a fifth a second until the box sinks 0.5 mm in 0.1 s."""
    should = mass * 9.81 / (2 * friction)
    world, rows = held(friction, 2 * should, name, mass)
    run(world, 0.5)
    force, heights, forces = 2 * should, [], []
    while len(heights) < 25 or heights[-25] - heights[-1] < 5e-4:
        force -= should * 0.2 * world.spec.dt
        assert force > 0.3 * should, "it never slips"
        world.robot.press(rows, force)
        world.step()
        heights.append(world.object_pose("thing").position[2])
        forces.append(world.pressed("hand"))
    assert np.mean(forces[-48:-24]) == pytest.approx(should, rel=0.1)


@pytest.mark.parametrize("name", ["panda", "ur5_gripper", "ur5_robotiq"])
def test_a_force_that_is_as_told_stays_so_and_another_one_is_soon_pressed_with(name):
    world, rows = held(0.5, 6.0, name, stand=True)
    run(world, 1.0)
    limits = world.robot.kept()["limits"]
    assert run(world, 0.5) == pytest.approx(6.0, rel=0.02)
    assert (world.robot.kept()["limits"] == limits).all()
    world.robot.press(rows, 9.0)
    assert run(world, 0.6)[-1] == pytest.approx(9.0, rel=0.05)


def test_a_hand_that_closes_without_a_force_regulates_none_any_more():
    world, rows = held(0.5, 4.0, "ur5_gripper")
    world.robot.limit_torque(rows, None)
    world.robot.press(rows, None)
    assert not world.robot.pressing
    assert run(world, 1.0)[-1] > 6.0


def test_a_regulated_force_is_kept_and_put_back():
    world, _ = held(0.5, 4.0, "ur5_gripper")
    kept = world.kept()
    other, _ = held(0.5, 9.0, "ur5_gripper")
    other.put_back(kept)
    run(other, 0.5)
    assert run(other, 0.5).mean() == pytest.approx(4.0, rel=0.05)


def test_each_of_two_hands_has_a_force_of_its_own():
    from grip_sim.specs import WorldSpec
    from grip_sim.world import World

    robot = World(WorldSpec(robot="two_ur5_allegro")).robot
    hands = list(robot.description.hands)
    rows = {hand: robot.rows(robot.description.group(hand)) for hand in hands}
    robot.press(rows[hands[1]], 4.0)
    assert robot.pressing == {hands[1]: sorted(rows[hands[1]].tolist())}
    robot.press(rows[hands[0]], 3.0)
    assert set(robot.pressing) == set(hands)
    assert len(hands) == 2


@pytest.mark.parametrize(("name", "mass"), [("panda", 0.2), ("panda", 0.5), ("ur5_gripper", 0.2)])
def test_what_is_held_weighs_at_the_wrist_and_slips_are_told_when_they_begin(name, mass):
    """The wrist bears m g, the fingers sum to the squeeze, and 0.5 mm in 0.1 s is a slip; what is held is none."""
    weight, squeeze = mass * 9.81, 2 * mass * 9.81
    world, rows = held(0.5, squeeze, name, mass)
    run(world, 0.5)
    ((link, wrench),) = world.wrench("hand").items()
    force = world.link_pose(link).rotation() @ wrench[:3]
    assert -force[2] == pytest.approx(weight, rel=0.01)
    assert np.linalg.norm(force) == pytest.approx(weight, rel=0.05)
    assert sum(world.hand_contacts("hand").values()) / 2 == pytest.approx(squeeze, rel=0.01)
    points = world.contact_points("hand")
    thing = world.object_pose("thing").position
    assert {other for _, other, _, _ in points} == {"thing"}
    for link, force in world.hand_contacts("hand").items():
        mine = [(np.array(at), np.array(push)) for name, _, at, push in points if name == link]
        assert np.linalg.norm(sum(push for _, push in mine)) == pytest.approx(force)
        assert all((thing - at) @ push > 0 for at, push in mine), "a link pushes what is held away from itself"
        borne = world.link_wrenches("hand")[link].reshape(2, 3) @ world.link_pose(link).rotation().T
        assert borne[0] == pytest.approx(-sum(push for _, push in mine))
        about = world.link_pose(link).position
        assert borne[1] == pytest.approx(-sum(np.cross(at - about, push) for at, push in mine))
    world.slips("hand")
    for _ in range(24):
        run(world, 0.02)
        assert max(world.slips("hand").values(), default=0.0) < 1e-3
    world.robot.press(rows, 0.4 * weight)
    heights = [world.object_pose("thing").position[2]]
    while max(world.slips("hand").values(), default=0.0) < 5e-3:
        for _ in range(5):
            world.step()
            heights.append(world.object_pose("thing").position[2])
        assert heights[0] - heights[-1] < 2e-3, "it falls, and nobody says so"
    sliding = len(heights) - int(np.argmax(heights[0] - np.array(heights) > 1e-4))
    assert sliding * world.spec.dt <= 0.05
