"""`grip launch` as somebody types it, where nothing has to be started."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="launch files are read in the room of ROS")

from grip_bt.cli.__main__ import main

FILE = """
<launch>
  <arg name="robot_ip" description="where the robot is"/>
  <arg name="kind" default="ur5e"><choice value="ur5e"/><choice value="ur10e"/></arg>
  <arg name="description" default="$(find-pkg-share nowhere)/x.urdf"/>
  <executable cmd="echo $(var robot_ip)"/>
</launch>
"""


def test_the_arguments_of_a_launch_file_are_shown_without_being_given(tmp_path: Path, capsys) -> None:
    file = tmp_path / "it.launch.xml"
    file.write_text(FILE)
    assert main(["launch", "--show-args", str(file)]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "robot_ip: needed; where the robot is",
        "kind: default 'ur5e', one of ur5e, ur10e",
        "description: default '$(find-pkg-share nowhere)/x.urdf'",
    ]


def test_a_file_without_arguments_says_so(tmp_path: Path, capsys) -> None:
    file = tmp_path / "it.launch.yaml"
    file.write_text('launch:\n- executable: {cmd: "echo hi"}\n')
    assert main(["launch", "--show-args", str(file)]) == 0
    assert capsys.readouterr().out == "the file declares no arguments\n"


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("it.launch.py", "", "is a program for `ros2 launch`"),
        ("it.launch", '<launch><node pkg="a" type="b" name="c"/></launch>', ":1: this is a ROS 1 launch file: 'type='"),
        ("gone.launch.xml", None, "gone.launch.xml"),
    ],
)
def test_arguments_that_cannot_be_shown_are_explained(tmp_path: Path, capsys, name, text, told) -> None:
    if text is not None:
        (tmp_path / name).write_text(text)
    assert main(["launch", "--show-args", str(tmp_path / name)]) == 1
    assert told in capsys.readouterr().err
