"""`grip launch` as somebody types it, where nothing has to be started."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="launch files are run in the room of ROS")

from grip_bt.cli.__main__ import main


def test_a_launch_file_is_run_by_the_tools_of_ros(tmp_path: Path, monkeypatch, capsys) -> None:
    (tmp_path / "ros2").write_text("#!/bin/sh\n")
    (tmp_path / "ros2").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    file = tmp_path / "it.launch.xml"
    file.write_text("<launch/>")
    assert main(["launch", "--check", "--json", str(file), "robot_ip:=10.0.0.2"]) == 0
    (member,) = json.loads(capsys.readouterr().out)
    assert member["command"] == [str(tmp_path / "ros2"), "launch", str(file), "robot_ip:=10.0.0.2"]
    assert main(["launch", "--check", str(file), "robot_ip"]) == 1
    assert "'robot_ip' isn't an argument of a launch file: NAME:=VALUE" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "told"), [("<launch/>", "launch files are run by `ros2 launch`"), (None, "there is no such file")]
)
def test_a_launch_file_that_cannot_be_run_says_what_to_do(tmp_path: Path, monkeypatch, capsys, text, told) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    if text is not None:
        (tmp_path / "it.launch.xml").write_text(text)
    assert main(["launch", str(tmp_path / "it.launch.xml")]) == 1
    assert told in capsys.readouterr().err
