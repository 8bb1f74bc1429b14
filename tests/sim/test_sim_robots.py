"""Ready-made robots in the physics: they stand where they rest, and fingers that follow others do."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from grip_bt.commanders.description.load import load_robot
from grip_bt.commanders.description.packages import ROBOTS
from grip_sim.specs import BoxSpec, WorldSpec

pytestmark = pytest.mark.sim
pytest.importorskip("sapien")


@pytest.mark.parametrize(
    "name", ["panda", "xarm7", "xarm7_gripper", "ur5_robotiq", "ur10_shadow", "shadow_left", "two_ur5_allegro"]
)
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


@pytest.mark.parametrize("name", ROBOTS)
def test_what_physics_reads_has_all_collision_shapes_and_neither_looks_nor_mimics(name):
    from grip_sim.robot import bare

    urdf = load_robot(name).urdf
    full, left = ET.fromstring(urdf), ET.fromstring(bare(urdf))
    assert not [*left.iter("visual"), *left.iter("mimic")]
    assert len(list(left.iter("collision"))) == len(list(full.iter("collision"))) > 0


@pytest.mark.parametrize("dynamics", ['friction="0"', 'damping="0.1"', ""])
def test_a_joint_may_say_friction_or_damping_alone(dynamics, tmp_path):
    from grip_bt.commanders.description.config import RobotConfig
    from grip_bt.commanders.description.load import load_robot as load
    from grip_sim.world import World

    inertial = '<inertial><mass value="1"/><inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial>'
    (tmp_path / "r.urdf").write_text(
        f'<robot name="r"><link name="base"/><link name="arm">{inertial}</link><joint name="j" type="revolute">'
        f'<parent link="base"/><child link="arm"/><axis xyz="0 1 0"/><dynamics {dynamics}/>'
        '<limit lower="-1" upper="1" effort="9"/></joint></robot>'
    )
    (tmp_path / "r.srdf").write_text(
        '<robot name="r"><group name="arm"><chain base_link="base" tip_link="arm"/></group></robot>'
    )
    robot = load(RobotConfig(urdf="r.urdf", srdf="r.srdf"), tmp_path)
    world = World(WorldSpec(robot="r"), robot)
    for _ in range(60):
        world.step()
    assert np.abs(world.robot.positions()).max() < 0.01


def test_the_second_finger_of_a_gripper_follows_the_first():
    from grip_sim.world import World

    world = World(WorldSpec(robot="panda"))
    world.robot.drive(world.robot.rows(world.robot.description.group("hand")), np.array([0.01]))
    for _ in range(120):
        world.step()
    fingers = world.robot.measure(world.robot.rows(("panda_finger_joint1", "panda_finger_joint2")))
    assert fingers.position == pytest.approx([0.01, 0.01], abs=1e-3)


@pytest.mark.parametrize("stuck", ["panda_finger_joint1", "panda_finger_joint2"])
def test_neither_finger_moves_while_one_of_two_that_slide_together_is_stuck(stuck):
    from grip_sim.faults import NOWHERE
    from grip_sim.world import World

    world = World(WorldSpec(robot="panda"))
    both = world.robot.rows(("panda_finger_joint1", "panda_finger_joint2"))
    begin = world.robot.positions()[both]
    for between, moved in ((NOWHERE, 0.0), (None, 0.02)):
        world.robot.restrict(stuck, between)
        world.robot.drive(both[:1], begin[:1] - 0.02)
        for _ in range(120):
            world.step()
        assert begin - world.robot.positions()[both] == pytest.approx([moved, moved], abs=1e-3)


@pytest.mark.parametrize(
    ("name", "holding"), [("ur5_gripper", (0.01, 0.02)), ("ur5_robotiq", (0.3, 0.7)), ("xarm7_gripper", (0.3, 0.75))]
)
def test_a_gripper_holds_a_box_between_its_fingers(name, holding):
    """The box hangs in the air: nothing but friction at the fingers keeps it there."""
    from grip_bt.commanders.kinematics.model import RobotModel
    from grip_sim.specs import ObjectSpec
    from grip_sim.world import World

    robot = load_robot(name)
    model = RobotModel(robot)
    tcp = model.grasp_pose(group="arm")
    assert tcp.rotation()[:, 2] == pytest.approx([0, 0, -1], abs=0.3), "the gripper looks down at rest"
    x, y, z = (float(c) for c in tcp.position)
    thing = ObjectSpec("thing", "box", 0.015, 0.05, (x, y, z - 0.01), float(np.arctan2(*tcp.rotation()[1::-1, 1])), 0.1)
    world = World(WorldSpec(robot=name, objects=(thing,)))
    row = world.robot.rows(world.robot.description.group("hand"))
    begin = world.object_pose("thing")
    opened, closed = (robot.named_state("hand", state).position[0] for state in ("open", "closed"))
    for step in range(360):
        world.robot.drive(row, np.array([opened + (closed - opened) * min(1.0, step / 85)]))
        if step < 150:
            world.move_object("thing", begin)  # held there until the fingers have come
        world.step()
    assert world.object_pose("thing").position[2] == pytest.approx(z - 0.01, abs=0.02)
    assert holding[0] < world.robot.measure(row).position[0] < holding[1]


def test_a_torque_limit_is_that_of_the_joints_that_follow_too():
    from grip_sim.world import World

    world = World(WorldSpec(robot="panda"))
    both = world.robot.rows(("panda_finger_joint1", "panda_finger_joint2"))
    world.robot.limit_torque(world.robot.rows(world.robot.description.group("hand")), 5.0)
    assert world.robot.kept()["limits"][both].tolist() == [5.0, 5.0]


@pytest.mark.parametrize("name", ["panda_allegro_left", "ur10_shadow", "ur5_robotiq", "xarm7_allegro"])
def test_what_a_robot_hides_of_the_view_is_known_from_its_joints_and_its_description(name):
    """The camera's segmentation is the judge: hulls, drawn without it, hide what the robot does and hardly more."""
    from dataclasses import replace

    from grip_bt.base.values import DepthImage, JointState
    from grip_bt.commanders.kinematics.model import RobotModel
    from grip_bt.nodes.camera_views import robot_pixels
    from grip_sim.specs import CameraSpec
    from grip_sim.world import World
    from grip_sim.worlds import load_world

    robot = load_robot(name)
    world = World(replace(load_world("table", 2), robot=name, cameras=(CameraSpec(shapes="collision"),)))
    world.step()
    taken = world.cameras.look("overhead")
    links = {link.name for link in world.robot.links}
    shown = np.array([name in links for name in taken.names] + [False])[taken.labels]
    measured = world.robot.measure(world.robot.rows(tuple(robot.joints)))
    hulls = RobotModel(robot).hulls(JointState(measured.names, measured.position))
    mine = robot_pixels(DepthImage(taken.depth, world.spec.cameras[0].info()), hulls)
    assert (shown & ~mine).mean() < 1e-3
    assert (mine & ~shown).mean() < 5e-3
    if name == "ur10_shadow":  # at home it stands between the camera and the table
        assert 0.45 < mine.mean() < 0.55


def test_joints_that_press_and_stand_still_are_measured_at_rest():
    """The solver's own velocities of them are up to 1 rad/s."""
    from grip_bt.commanders.kinematics.model import RobotModel
    from grip_sim.world import World

    robot = load_robot("xarm7_gripper")
    place = RobotModel(robot).grasp_pose(group="arm").position
    world = World(WorldSpec(robot="xarm7_gripper", boxes=(BoxSpec("post", (0.04, 0.04, 0.1), tuple(place)),)))
    rows = world.robot.rows(robot.group("hand"))
    world.robot.drive(rows, robot.named_state("hand", "closed").position)
    for _ in range(480):
        world.step()
    assert world.hand_contacts("hand")
    solver = np.abs(world.robot.body.get_qvel()).max()
    assert np.abs(world.robot.velocities()).max() < 0.02 < solver
