"""What `grip sim` feels and is told on topics, as a robot's own drivers have them: said and heard by a plain client."""

from __future__ import annotations

import numpy as np
import pytest
from patience import until
from service_client import service_client
from simulated_robot import simulated_robot

from grip_bt.commanders.description.load import load_robot

pytestmark = [pytest.mark.ros, pytest.mark.sim, pytest.mark.slow, pytest.mark.timeout(600)]
MASS, SQUEEZE = 0.3, 12.0
PROJECT = """grip: 1
robot: panda
arms: {right: {group: arm, hand: gripper}}
hands: {gripper: {group: hand}}
world: held
ros:
  joint_states: /joint_states
  controllers:
    gripper: {gripper: /panda_gripper/gripper_action}
"""
WRENCH = "geometry_msgs/msg/WrenchStamped"
TRAJECTORY = "trajectory_msgs/msg/JointTrajectory", "/right_controller/joint_trajectory"
ARM = [f"panda_joint{number}" for number in range(1, 8)]
FINGERS = ("panda_leftfinger", "panda_rightfinger")


@pytest.fixture(scope="module")
def served(own_domain, tmp_path_factory):
    """Serve a gripper around a box on a stand; give a plain client, and the file of what `grip sim` prints."""
    from grip_bt.commanders.kinematics.model import RobotModel

    tcp = RobotModel(load_robot("panda")).grasp_pose(group="arm")
    yaw = float(np.arctan2(*tcp.rotation()[1::-1, 1]))
    x, y, z = (float(c) for c in tcp.position)
    folder = tmp_path_factory.mktemp("touch")
    (folder / "worlds").mkdir()
    (folder / "worlds" / "held.yaml").write_text(f"""grip: 1
fixtures:
  stand: {{box: [0.02, 0.02, 0.1], at: [{x}, {y}, {z - 0.136}]}}
objects:
  thing: {{shape: box, radius: 0.015, height: 0.05, mass: {MASS}, at: [{x}, {y + 0.5}, 0]}}
""")
    setup = folder / "setup.bash"
    options = "--setup", str(setup), "--pace", "4"
    with (
        simulated_robot(folder, own_domain, *options, project=PROJECT, world="held") as world,
        service_client(setup) as ask,
    ):
        gripper = "control_msgs/action/GripperCommand", "/panda_gripper/gripper_action"
        assert ask(*gripper, command={"position": 0.04, "max_effort": 20.0})["reached_goal"]
        turned = {"z": float(np.sin(yaw / 2)), "w": float(np.cos(yaw / 2))}
        pose = {"position": {"x": x, "y": y, "z": z - 0.01}, "orientation": turned}
        state = "simulation_interfaces/srv/SetEntityState", "/set_entity_state"
        assert ask(*state, entity="thing", set_pose=True, state={"pose": pose})["result"]["result"] == 1
        yield ask, world.log


def wrench(ask, name):
    """Return the frame of a sensor, its force and its torque."""
    said = ask(WRENCH, f"/{name}_force_torque_sensor_broadcaster/wrench")
    force, torque = ([said["wrench"][part][axis] for axis in "xyz"] for part in ("force", "torque"))
    return said["header"]["frame_id"], np.array(force), np.array(torque)


def joints(ask):
    said = ask("sensor_msgs/msg/JointState", "/joint_states")
    return dict(zip(said["name"], said["position"], strict=True))


def trajectory(positions, seconds):
    return {"joint_names": list(positions), "points": [point(positions.values(), seconds)]}


def point(positions, seconds):
    return {"positions": list(positions), "time_from_start": {"sec": int(seconds), "nanosec": int(seconds % 1 * 1e9)}}


def test_a_thing_that_a_plain_client_has_lifted_weighs_at_the_wrist_and_presses_on_the_fingers(served):
    from grip_bt.base.values import JointState
    from grip_bt.commanders.kinematics.model import RobotModel

    ask, _ = served
    frame, force, torque = wrench(ask, "right")
    assert frame == "panda_hand"
    assert force == pytest.approx(np.zeros(3), abs=0.05)
    assert torque == pytest.approx(np.zeros(3), abs=0.01)
    assert wrench(ask, FINGERS[0])[1] == pytest.approx(np.zeros(3))
    closing = {"position": 0.0, "max_effort": SQUEEZE}
    assert ask("control_msgs/action/GripperCommand", "/panda_gripper/gripper_action", command=closing)["stalled"]
    began = {name: joints(ask)[name] for name in ARM}
    raised = began | {"panda_joint2": began["panda_joint2"] - 0.15}
    ask(*TRAJECTORY, **trajectory(raised, 2.0))
    until(lambda: abs(joints(ask)["panda_joint2"] - raised["panda_joint2"]) < 2e-3, "the arm doesn't come to its goal")
    weight = MASS * 9.81
    until(lambda: np.linalg.norm(wrench(ask, "right")[1]) == pytest.approx(weight, rel=0.03), "it weighs otherwise")
    model = RobotModel(load_robot("panda"))
    place = model.link_poses(JointState(tuple(raised), list(raised.values())))["panda_hand"]
    _, force, torque = wrench(ask, "right")
    assert place.rotation() @ force == pytest.approx([0, 0, -weight], abs=0.15)
    thing = ask("simulation_interfaces/srv/GetEntityState", "/get_entity_state", entity="thing")["state"]["pose"]
    lever = np.array([thing["position"][axis] for axis in "xyz"]) - place.position
    assert place.rotation() @ torque == pytest.approx(np.cross(lever, [0, 0, -weight]), abs=0.02)
    pressed = [wrench(ask, finger) for finger in FINGERS]
    assert [frame for frame, _, _ in pressed] == list(FINGERS)
    for _, force, _ in pressed:
        assert np.linalg.norm(force) == pytest.approx(SQUEEZE, rel=0.15)


def test_a_trajectory_on_the_topic_takes_the_place_of_another_one(served):
    ask, _ = served
    there = {name: joints(ask)[name] for name in ARM}
    away = there | {"panda_joint1": there["panda_joint1"] + 1.0}
    ask(*TRAJECTORY, **trajectory(away, 30.0))
    until(lambda: abs(joints(ask)["panda_joint1"] - there["panda_joint1"]) > 0.02, "the arm doesn't move")
    ask(*TRAJECTORY, **trajectory(there, 1.0))
    until(lambda: abs(joints(ask)["panda_joint1"] - there["panda_joint1"]) < 2e-3, "the arm doesn't come back")


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"joint_names": ["panda_joint1"]}, "it moves panda_joint1, not panda_joint1, panda_joint2"),
        ({"points": []}, "the times of its points must rise from 0 on, and are []"),
        ({"points": [point([0.0] * 6, 1)]}, "each point needs a finite position of each of 7 joints"),
        ({"points": [point([0.0, 0, 0, 0.5, 0, 1, 0], 1)]}, "panda_joint4 can go from -3.072 to -0.0698, not to 0.5"),
    ],
)
def test_a_trajectory_that_cannot_be_followed_is_refused_in_words_on_the_topic_as_by_the_action(served, changed, said):
    ask, log = served
    before = joints(ask)
    asked = {**trajectory({name: before[name] for name in ARM}, 1.0), **changed}
    counted = log.read_text().count(said)
    ask(*TRAJECTORY, **asked)
    until(lambda: log.read_text().count(said) == counted + 1, "nothing is said")
    action = "control_msgs/action/FollowJointTrajectory", "/right_controller/follow_joint_trajectory"
    assert ask(*action, trajectory=asked) == {"accepted": False}
    until(lambda: log.read_text().count(f"right_controller refuses a goal: {said}") == counted + 2, "nothing is said")
    assert [joints(ask)[name] for name in ARM] == pytest.approx([before[name] for name in ARM], abs=2e-3)
