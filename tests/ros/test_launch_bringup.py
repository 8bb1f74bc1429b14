"""Bringup files as robots, cameras and vehicles come with: read as ROS reads them, or refused by name and line."""

from __future__ import annotations

from pathlib import Path

import pytest

from grip_bt.ros.launch import LaunchError, read_launch_file
from grip_bt.ros.launch.group import Member

FILES = Path(__file__).parent / "data" / "bringup"
PROGRAMS = {
    "arm_driver": (),
    "controller_manager": ("ros2_control_node", "spawner"),
    "bridge": ("bridge", "websocket", "api"),
    "camera_driver": ("camera_node", "rectify_node"),
    "vehicle": ("poser",),
    "base_driver": ("base",),
    "gripper_driver": ("gripper",),
    "simulation": ("create",),
}
SHARED = {
    "arm_driver/urdf/arm.urdf.xacro": '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    '<xacro:arg name="name" default="none"/><link name="$(arg name)_base"/></robot>',
    "arm_driver/config/controllers.yaml": "/**: {ros__parameters: {update_rate: 1}}\n",
    "camera_driver/config/front.yaml": "/**: {ros__parameters: {}}\n",
}


@pytest.fixture(scope="module")
def prefix(tmp_path_factory) -> Path:
    """Return a prefix with the packages of these files; their programs do nothing."""
    root = tmp_path_factory.mktemp("prefix")
    for package, programs in PROGRAMS.items():
        (root / "share" / package).mkdir(parents=True)
        folder = root / "lib" / package
        folder.mkdir(parents=True)
        for name in programs:
            (folder / name).write_text("#!/bin/sh\n")
            (folder / name).chmod(0o755)
    for name, text in SHARED.items():
        (root / "share" / name).parent.mkdir(parents=True, exist_ok=True)
        (root / "share" / name).write_text(text)
    return root


@pytest.fixture
def read(prefix, monkeypatch):
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(prefix))
    return lambda name, env=None, **arguments: read_launch_file(FILES / name, arguments, env)


def words(launch: list[Member], number: int = 0) -> list[str]:
    return list(launch[number].command[1:])


def test_an_arm_starts_its_controllers_one_after_the_other(read):
    launch = read("arm.launch.xml", robot_ip="10.0.0.2")
    assert [p.after for p in launch] == [0, 2.0, 2.5]
    assert {"update_rate:=500", "ip:='10.0.0.2'"} <= set(words(launch))
    assert any('<link name="six_base"/>' in word for word in words(launch))
    assert words(launch, 2) == ["scaled_trajectory_controller", "-c", "/controller_manager"]
    for fake, model in (("true", "six"), ("false", "seven")):
        other = read("arm.launch.xml", robot_ip="x", use_fake_hardware=fake, model=model)
        assert "update_rate:=100" in words(other)


def test_a_bridge_gets_its_expressions_as_ros_gives_them(read):
    launch = read("bridge.launch.xml")
    assert r"assets:=['^package://(?:[-\w]+/)*[-\w]+\.(?:dae|stl)$']" in words(launch)
    assert "topic_whitelist:=['.*']" in words(launch)


def test_a_web_socket_is_started_with_or_without_its_certificate(read):
    plain, safe = read("websocket.launch.xml"), read("websocket.launch.xml", ssl="true", certfile="/c.pem")
    assert ["certfile:=/c.pem" in words(launch) for launch in (plain, safe)] == [False, True]
    assert [p.name for p in plain] == [p.name for p in safe] == ["websocket", "api"]


def test_a_camera_is_named_remapped_and_started_again(read, prefix):
    launch = read("camera.launch.yaml", serial="0815")
    driver, rectify = launch
    assert (driver.restart, driver.restart_delay, driver.restarts) == ("always", 2.0, 3)
    assert {"__ns:=/front", "image_raw:=color/image_raw", "serial:='0815'"} <= set(driver.command)
    assert {str(prefix / "share/camera_driver/config/front.yaml"), "distortion:=[0.0, 0.1, 0.2]"} <= set(driver.command)
    assert "__ns:=/front" in rectify.command
    with pytest.raises(LaunchError, match="there is no file .*back.yaml"):
        read("camera.launch.yaml", camera="back")


def test_a_lidar_in_a_container_is_refused_with_what_to_do(read):
    with pytest.raises(LaunchError, match=r"lidar.launch.yaml:3: <node_container> is not supported.*ros2 launch"):
        read("lidar.launch.yaml")


def test_a_vehicle_nests_name_spaces_conditions_and_includes(read):
    gnss, imu = read("vehicle.launch.xml")
    assert {"__ns:=/sensing/gnss", "fix:=ublox/nav_sat_fix", "covariance:=1.5"} <= set(gnss.command)
    assert {"__ns:=/sensing", "fix:=/imu"} <= set(imu.command)
    (imu,) = read("vehicle.launch.xml", gnss="septentrio", launch_driver="false")
    assert "fix:=/imu" in imu.command


def test_a_base_has_its_environment_and_nested_parameters(read, prefix, monkeypatch):
    monkeypatch.delenv("PLUGINS", raising=False)
    monkeypatch.setenv("WORDS", "first")
    monkeypatch.setenv("BASE_PORT", "/dev/base")
    (base,) = read("base.launch.xml", env={"DISPLAY": ":0"})
    assert base.env["PLUGINS"] == f"/first:{prefix}/lib"
    assert (base.env["WORDS"], base.env["OMP_NUM_THREADS"]) == ("first,last", "1")
    assert "DISPLAY" not in base.env
    assert base.command[:3] == ("nice", "-n", "5")
    assert {"wheel.radius:=0.1", "wheel.names:=[left, right]", "port:=/dev/base", "debug"} <= set(base.command)


def test_a_gripper_ends_all_and_warns_where_it_is_fast(read):
    fast, slow = read("gripper.launch.xml"), read("gripper.launch.xml", speed="0.05", side="left")
    assert fast[0].ends_all
    assert {"speed:=0.05", "__ns:=/left", "__node:=left_gripper"} <= set(words(slow))
    assert "shutdown" not in [p.name for p in (*fast, *slow)]


def test_a_simulation_spawns_its_robot_when_it_runs(read):
    launch = read("simulation.launch.xml")
    simulator, create, said = launch
    assert (simulator.command, create.after) == (("simulator", "-r", "empty.sdf"), 15.5)
    assert words(launch, 1)[:6] == ["-name", "arm", "-topic", "robot_description", "-x", "1.482"]
    assert "use_sim_time:=true" in create.command
    assert said.command == ("/bin/sh", "-c", "echo False | cat")


def test_a_recording_ends_after_its_time(read):
    launch = read("recording.launch.yaml", seconds="5")
    assert words(launch) == ["--out", f"{FILES}/bags/a b"]
    assert launch[0].env == {"LEVEL": "3"}
    assert [(p.name, p.after) for p in launch if p.ends_all] == [("shutdown", 5)]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('<timer period="soon"><log message="x"/></timer>', "period is a number of seconds, not 'soon'"),
        ('<timer period="-1"><log message="x"/></timer>', "period is a number of seconds, not '-1'"),
        ('<timer><log message="x"/></timer>', "<timer> needs the attribute 'period'"),
        ('<executable cmd="x" respawn_max_retries="many"/>', "respawn_max_retries is a whole number"),
        ("<executable cmd=\"$(eval 'open(1)')\"/>", r"\$\(eval 'open\(1\)'\): .*only literals are computed here"),
        ("<executable cmd=\"$(eval 'sim == 1')\"/>", "'sim' is no value; a text stands in quotation marks"),
        ('<executable cmd="$(eval 1 + 1)"/>', "eval ...\\) takes 1 word, not 3"),
    ],
)
def test_what_is_wrong_is_told(tmp_path, text, reason):
    file = tmp_path / "it.launch.xml"
    file.write_text(f"<launch>{text}</launch>")
    with pytest.raises(LaunchError, match=reason):
        read_launch_file(file)
