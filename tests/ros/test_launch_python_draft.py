"""A launch file in Python is refused, and said in XML as far as it can be read without running it."""

from __future__ import annotations

import pytest

from grip_bt.ros.launch import read_arguments, read_launch_file
from grip_bt.ros.launch.element import LaunchError
from grip_bt.ros.launch.python_draft import draft_of

BRINGUP = """
import os
from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, IncludeLaunchDescription, TimerAction
from launch.conditions import IfCondition, UnlessCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

open("ran", "w")


def generate_launch_description():
    ip = LaunchConfiguration("robot_ip")
    share = get_package_share_directory("my_robot")
    config = os.path.join(share, "config", "arm.yaml")
    camera = Node(
        package="usb_cam", executable="usb_cam_node_exe", name="cam", namespace="left",
        parameters=[{"rate": 30, "flip": True}, config], remappings=[("image_raw", "image")],
        condition=UnlessCondition(LaunchConfiguration("bare")),
    )
    driver = Node(package="ur_robot_driver", executable=compute(), arguments=["--ip", ip, ["x", ip]])
    return LaunchDescription([
        DeclareLaunchArgument("robot_ip", description="of the controller"),
        DeclareLaunchArgument("bare", default_value="false", choices=["true", "false"]),
        camera, driver,
        IncludeLaunchDescription(
            PythonLaunchDescriptionSource([PathJoinSubstitution([FindPackageShare("other"), "launch", "o.launch.py"])]),
            launch_arguments={"ip": ip}.items(), condition=IfCondition("true"),
        ),
        TimerAction(period=3.0, actions=[ExecuteProcess(cmd=["ros2", "bag", "record"])]),
    ])
"""
DRAFT = """\
<launch>
  <arg name="robot_ip" description="of the controller" />
  <arg name="bare" default="false">
    <choice value="true" />
    <choice value="false" />
  </arg>
  <node pkg="usb_cam" exec="usb_cam_node_exe" name="cam" namespace="left" unless="$(var bare)">
    <param name="rate" value="30" />
    <param name="flip" value="true" />
    <param from="$(find-pkg-share my_robot)/config/arm.yaml" />
    <remap from="image_raw" to="image" />
  </node>
  <node pkg="ur_robot_driver" exec="..." args="--ip $(var robot_ip) x$(var robot_ip)" />
  <include file="$(find-pkg-share other)/launch/o.launch.py" if="true">
    <arg name="ip" value="$(var robot_ip)" />
  </include>
  <!-- line 33: TimerAction: what is in it belongs into a <timer period="..."> -->
  <executable cmd="ros2 bag record" />
</launch>"""


def test_what_a_python_file_starts_is_said_in_xml_and_nothing_of_it_is_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "bringup.launch.py"
    file.write_text(BRINGUP)
    assert draft_of(file) == DRAFT
    with pytest.raises(
        LaunchError, match="A draft of bringup.launch.xml, read without running it:\n<launch>"
    ) as caught:
        read_launch_file(file)
    assert "source /opt/ros/jazzy/setup.bash" in str(caught.value)
    with pytest.raises(LaunchError, match='<arg name="robot_ip"'):
        read_arguments(file)
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x = 1\n", "or say the same in XML or YAML"),
        ("def (\n", "can't be read: invalid syntax"),
        ("Node()\nNode(package=a + b, **more)\n", '<node pkg="......" exec="..."'),
        ("a = b\nb = a\nNode(package=a, executable='x')\n", '<node pkg="..." exec="x"'),
    ],
)
def test_a_file_of_which_little_can_be_said_is_refused_likewise(tmp_path, text, said):
    file = tmp_path / "odd.launch.py"
    file.write_text(text)
    with pytest.raises(LaunchError) as caught:
        read_launch_file(file)
    assert said in str(caught.value)


def test_a_python_file_that_is_not_there_is_told_so(tmp_path):
    with pytest.raises(LaunchError, match="there is no such file"):
        read_launch_file(tmp_path / "no.launch.py")


def test_a_draft_that_only_needs_its_packages_is_read_as_it_is(tmp_path):
    python, xml = tmp_path / "it.launch.py", tmp_path / "it.launch.xml"
    python.write_text(
        "DeclareLaunchArgument('n', default_value='1')\nExecuteProcess(cmd=['sleep', LaunchConfiguration('n')])\n"
    )
    xml.write_text(draft_of(python))
    (process,) = read_launch_file(xml, {"n": "5"}).processes
    assert process.command == ("sleep", "5")
