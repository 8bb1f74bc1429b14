"""A served robot says what it is and where its links are, to any client: RViz, TF, programs that aren't ours."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from simulated_robot import simulated_robot

import grip_bt.ros  # noqa: F401 - its settings come before any message package
from grip_bt.base.values import Pose
from grip_bt.commanders.description.load import load_robot

pytestmark = pytest.mark.ros
LISTENER = Path(__file__).parent / "data" / "plain_listener.py"


@pytest.mark.parametrize("name", ["panda_allegro", "ur10_shadow", "xarm7_gripper", "two_ur5_allegro"])
def test_joints_move_their_links_as_pinocchio_has_it(name):
    from grip_bt.commanders.description.tree import Tree

    robot = load_robot(name)
    model = pin.buildModelFromXML(robot.urdf)
    data, rng = model.createData(), np.random.default_rng(7)
    joints = [joint for joint in Tree.of(robot.urdf).joints.values() if joint.movable]
    assert {joint.name for joint in joints} == {str(n) for n in model.names if n != "universe"}
    for _ in range(5):
        q = rng.uniform(-0.8, 0.8, model.nq)
        pin.framesForwardKinematics(model, data, q)
        for joint in joints:
            position = float(q[model.joints[model.getJointId(joint.name)].idx_q])
            parent = data.oMf[model.getFrameId(joint.origin.frame)]
            link = data.oMf[model.getFrameId(joint.child)]
            assert np.allclose(joint.pose(position).matrix(), parent.actInv(link).homogeneous, atol=1e-9)


@pytest.mark.sim
@pytest.mark.slow
@pytest.mark.timeout(600)
def test_a_plain_client_in_a_shell_of_its_own_hears_description_frames_and_clock(own_domain, tmp_path):
    setup = tmp_path / "setup.bash"
    with simulated_robot(tmp_path, own_domain, "--simulated-time", "--setup", str(setup)):
        clean = {name: os.environ[name] for name in ("PATH", "HOME")}  # a shell that has sourced nothing
        heard = subprocess.run(
            ["bash", "-c", f'source "{setup}"; exec "{sys.executable}" "{LISTENER}"'],
            env=clean,
            capture_output=True,
            text=True,
        )
    assert heard.returncode == 0, heard.stderr
    heard = json.loads(heard.stdout.splitlines()[-1])
    robot = load_robot("panda_allegro")
    links = set(heard["robot"])
    tree = heard["static"] | heard["moving"]
    assert links - set(tree) <= {"world"}, "every link has its frame"
    assert "overhead_optical" in heard["static"]
    assert heard["clock"][-1] < 1000, "the clock tells simulated time"
    assert heard["stamp"] < 1000, "so do stamps"

    def in_world(frame):
        if frame not in tree:
            return np.eye(4)
        parent, position, quaternion = tree[frame]
        return in_world(parent) @ Pose(position, quaternion).matrix()

    model = pin.buildModelFromXML(robot.urdf)
    data = model.createData()
    q = pin.neutral(model)
    for name, position in robot.at_rest.items():
        q[model.joints[model.getJointId(name)].idx_q] = position
    pin.framesForwardKinematics(model, data, q)
    flange = data.oMf[model.getFrameId("panda_link7")].homogeneous
    assert np.allclose(in_world("panda_link7"), flange, atol=0.02), "at rest, but for what gravity does"
