"""Which ROS there is, and what is never mixed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from grip_bt.ros.command import child_environment
from grip_bt.ros.environment import DDS_PROFILE, environment

WHEELS = Path("/venv/lib/rclpy")


@pytest.fixture
def sourced(tmp_path):
    prefix = tmp_path / "opt" / "ros"
    (prefix / "share" / "rclpy").mkdir(parents=True)
    return {"AMENT_PREFIX_PATH": str(prefix), "ROS_DISTRO": "jazzy"}


def test_a_mix_of_wheels_and_a_sourced_ros_is_refused_with_a_remedy(sourced):
    here = environment(sourced, WHEELS)
    assert here.kind == "mixed"
    assert not here.usable
    assert "use one of the two" in here.remedy
    assert str(WHEELS) in here.detail


def test_each_alone_is_usable(sourced):
    assert environment({}, WHEELS).kind == "wheels"
    assert environment(sourced, None).kind == "sourced"
    assert environment(sourced, None).usable


def test_none_is_told_with_what_to_install():
    here = environment({}, None)
    assert here.kind == "none"
    assert "pip install" in here.remedy


def test_an_overlay_of_built_interfaces_is_no_ros_of_its_own(tmp_path):
    assert environment({"AMENT_PREFIX_PATH": str(tmp_path)}, WHEELS).kind == "wheels"


def test_importing_the_room_sets_what_ros_reads_and_loads_none_of_it():
    code = (
        "import os, sys, grip_bt.ros; assert 'rclpy' not in sys.modules;"
        "print(os.environ['ROS_PYTHON_CHECK_FIELDS'], os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'],"
        "os.environ['FASTRTPS_DEFAULT_PROFILES_FILE'])"
    )
    env = {k: v for k, v in os.environ.items() if not k.startswith(("ROS_", "FAST"))}
    done = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["1", "LOCALHOST", str(DDS_PROFILE)]


def test_what_belongs_to_this_interpreter_does_not_reach_children(monkeypatch):
    bundled = f"{sys.prefix}/lib/python3.11/site-packages/ros_rcl.libs"
    monkeypatch.setenv("LD_LIBRARY_PATH", os.pathsep.join([f"{sys.prefix}/lib", bundled, "/usr/lib/mine"]))
    monkeypatch.setenv("_ROS_WHEELS_BOOTSTRAP_COMPLETE", "1")
    env = child_environment(domain_id=12)
    assert env["LD_LIBRARY_PATH"] == "/usr/lib/mine"
    assert "_ROS_WHEELS_BOOTSTRAP_COMPLETE" not in env
    assert env["ROS_DOMAIN_ID"] == "12"
