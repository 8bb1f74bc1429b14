"""A simulated world is controlled over ROS by the standard's services, and by a robot's usual ones, from any client."""

from __future__ import annotations

import numpy as np
import pytest
from service_client import service_client
from simulated_robot import simulated_robot

pytestmark = [pytest.mark.ros, pytest.mark.sim, pytest.mark.slow, pytest.mark.timeout(600)]
PROJECT = """grip: 1
robot: panda
arms: {right: {group: arm, hand: gripper}}
hands: {gripper: {group: hand}}
world: bench
ros:
  joint_states: /joint_states
  controllers:
    gripper: {gripper: /panda_gripper/gripper_action}
"""
WORLD = """grip: 1
fixtures:
  table: {box: [0.7, 1.2, 0.1], at: [0.65, 0, -0.1]}
regions:
  middle: {size: [0.2, 0.2, 0.2], at: [0.5, 0, 0]}
objects:
  cube: {model: cube, at: [0.5, 0.1, 0]}
  drawn: {draw: 1, in: middle, of: [{shape: cylinder, radius: 0.02, height: 0.1}]}
cameras:
  overhead: {at: [0.5, 0, 1.2], look_at: [0.5, 0, 0]}
"""
OK = 1


@pytest.fixture(scope="module")
def call(own_domain, tmp_path_factory):
    """Return a function that calls a service or an action from a shell that has sourced one file."""
    folder = tmp_path_factory.mktemp("world")
    (folder / "worlds").mkdir()
    (folder / "worlds" / "bench.yaml").write_text(WORLD)
    setup = folder / "setup.bash"
    with (
        simulated_robot(folder, own_domain, "--setup", str(setup), "--pace", "4", project=PROJECT, world="bench"),
        service_client(setup) as ask,
    ):
        yield ask


@pytest.fixture
def standard(call):
    """Return a function that calls one of the standard's services, and checks its result."""

    def ask(kind: str, result: int = OK, /, **fields: object) -> dict[str, object]:
        name = "".join(f"_{c.lower()}" if c.isupper() else c for c in kind).lstrip("_")
        said = call(f"simulation_interfaces/srv/{kind}", f"/{name}", **fields)
        assert said.get("result", {}).get("result", OK) == result, said
        return said

    return ask


@pytest.fixture(autouse=True)
def playing(call):
    """Have each test begin with a world that goes on."""
    call("simulation_interfaces/srv/SetSimulationState", "/set_simulation_state", state={"state": 1})


def place(standard, name: str) -> np.ndarray:
    position = standard("GetEntityState", entity=name)["state"]["pose"]["position"]
    return np.array([position[axis] for axis in "xyz"])


def test_a_world_is_paused_stepped_changed_and_reset(standard):
    features = standard("GetSimulatorFeatures")["features"]["features"]
    assert {0, 1, 10, 11, 20, 24, 25, 26, 31, 32} <= set(features)
    assert standard("GetEntities")["entities"] == ["cube", "cylinder_0"]
    assert standard("GetEntities", filters={"filter": "^cu"})["entities"] == ["cube"]
    standard("StepSimulation", 3, steps=1)
    standard("SetSimulationState", state={"state": 2})
    standard("SetSimulationState", 101, state={"state": 2})
    assert standard("GetSimulationState")["state"]["state"] == 2
    first = place(standard, "cube")
    pose = {"position": {"x": 0.6, "y": -0.2, "z": 0.5}, "orientation": {"w": 1.0}}
    said = standard("SpawnEntity", name="toy", entity_resource={"uri": "mug"}, initial_pose={"pose": pose})
    assert said["entity_name"] == "toy"
    standard("SpawnEntity", 101, name="toy", entity_resource={"uri": "mug"}, initial_pose={"pose": pose})
    standard("SpawnEntity", 2, name="toy2", entity_resource={"uri": "mugg"}, initial_pose={"pose": pose})
    assert place(standard, "toy") == pytest.approx([0.6, -0.2, 0.5], abs=1e-6)
    standard("StepSimulation", steps=24)  # a tenth of a second of free fall
    fallen = 0.5 - place(standard, "toy")[2]
    assert fallen == pytest.approx(9.81 * 0.1**2 / 2, rel=0.06)
    standard("SetEntityState", entity="cube", state={"pose": pose}, set_pose=True)
    assert place(standard, "cube")[2] == pytest.approx(0.5)
    standard("SetEntityState", 2, entity="cup", state={"pose": pose}, set_pose=True)
    standard("DeleteEntity", entity="cylinder_0")
    standard("GetEntityState", 2, entity="cylinder_0")
    standard("ResetSimulation")
    assert standard("GetEntities")["entities"] == ["cube", "cylinder_0"]
    assert place(standard, "cube") == pytest.approx(first, abs=1e-6)
    standard("ResetSimulation", 0, scope=1)
    standard("SetSimulationState", state={"state": 1})


def test_a_world_is_drawn_anew_saved_and_restored(standard, call):
    before = place(standard, "cylinder_0")
    assert call("grip_msgs/srv/ResetToSeed", "/grip_sim/reset_to_seed", seed=7)["success"]
    other = place(standard, "cylinder_0")
    assert np.linalg.norm(other - before) > 0.01
    assert call("std_srvs/srv/Trigger", "/grip_sim/save")["success"]
    pose = {"position": {"x": 0.5, "y": -0.3, "z": 0.05}, "orientation": {"w": 1.0}}
    standard("SetEntityState", entity="cylinder_0", state={"pose": pose}, set_pose=True)
    assert call("std_srvs/srv/Trigger", "/grip_sim/restore")["success"]
    assert place(standard, "cylinder_0")[:2] == pytest.approx(other[:2], abs=2e-3)


def test_faults_are_injected_and_wrong_ones_explained(standard, call):
    inject = "grip_msgs/srv/InjectFault", "/grip_sim/inject_fault"
    said = call(*inject, name="bump", fault="{fault: push, of: cup, by: [1, 0, 0]}")
    assert not said["success"]
    assert "cube" in said["message"]
    assert "no `of`" not in call(*inject, name="x", fault="{fault: explode}")["message"]
    standard("SetSimulationState", state={"state": 2})
    assert call(*inject, name="bump", fault="{fault: push, of: cube, by: [1, 0, 0]}")["success"]
    standard("StepSimulation", steps=2)
    assert standard("GetEntityState", entity="cube")["state"]["twist"]["linear"]["x"] > 0.5
    standard("SetSimulationState", state={"state": 1})


def test_controllers_are_listed_and_switched_and_a_gripper_closes(call):
    manager = "/controller_manager"
    listed = call("controller_manager_msgs/srv/ListControllers", f"{manager}/list_controllers")["controller"]
    assert {each["name"]: each["state"] for each in listed} == {"right_controller": "active", "panda_gripper": "active"}
    gripper = "control_msgs/action/GripperCommand", "/panda_gripper/gripper_action"
    opened = call(*gripper, command={"position": 0.04, "max_effort": 20.0})
    assert opened["reached_goal"]
    assert opened["position"] == pytest.approx(0.04, abs=2e-3)
    switch = "controller_manager_msgs/srv/SwitchController", f"{manager}/switch_controller"
    wrong = call(*switch, deactivate_controllers=["left"], strictness=2)
    assert not wrong["ok"]
    assert "right_controller" in wrong["message"]
    assert call(*switch, deactivate_controllers=["panda_gripper"], strictness=2)["ok"]
    assert not call(*gripper, command={"position": 0.0})["accepted"]
    assert call(*switch, activate_controllers=["panda_gripper"], strictness=2)["ok"]
    assert call(*gripper, command={"position": 0.0, "max_effort": 20.0})["position"] < 3e-3
