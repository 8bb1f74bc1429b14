"""What leaves of `ros/` are asked for is checked before the first tick, when nothing has moved yet."""

from __future__ import annotations

import pytest

from grip_bt.app.runs.execute import run
from grip_bt.base.errors import MissingPartError, UnknownNameError
from grip_bt.ros.client.types import load_message, load_type

pytestmark = pytest.mark.ros
WRONG = {
    "ros/wait_for_message, with: {topic: /x, type: geometry_mgs/msg/Pose}": (
        "the interface package 'geometry_mgs' of geometry_mgs/msg/Pose (did you mean 'geometry_msgs'?) isn't available "
        "here. Fix: grip interfaces build FOLDER"
    ),
    "ros/wait_for_message, with: {topic: /x, value: Psoe}": "value: unknown type 'Psoe'; did you mean 'Pose'?",
    "ros/latest_message, with: {topic: /x, type: std_msgs/msg/Strng}": "did you mean 'std_msgs/msg/String'?",
    "ros/wait_for_messages, with: {topics: {/x: std_msgs/msg/String, /y: std_srvs/srv/Empty}}": (
        "'std_srvs/srv/Empty' isn't a message: a topic has a type such as 'sensor_msgs/msg/JointState'"
    ),
    "ros/publish, with: {topic: /x y, type: std_msgs/msg/Int64}, in: {value: v}": "'/x y' can't name a topic",
    "ros/get_parameter, with: {node: 3d_camera, name: rate}": "'3d_camera' can't name a topic, a service",
    "ros/set_parameter, with: {node: a//b, name: rate}, in: {value: v}": "'a//b' can't name a topic, a service",
}


@pytest.mark.parametrize("leaf", WRONG)
def test_what_cannot_be_is_told_before_anything_moves(leaf, tmp_path, domain, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    (tmp_path / "grip.yaml").write_text("grip: 1\n")
    task = tmp_path / "task.yaml"
    task.write_text(
        "grip: 1\nname: asks\ndata: {v: {type: int, value: 1}}\nroot:\n  kind: sequence\n  children:\n"
        f"    first: {{node: flow/wait, with: {{seconds: 0.01}}}}\n    then: {{node: {leaf}}}\n"
    )
    result = run(task)
    assert (result.status, result.ticks) == ("error", 0)
    assert str(result.error).startswith("then: ")
    assert WRONG[leaf] in str(result.error)


def test_a_package_that_is_like_none_is_not_guessed():
    with pytest.raises(MissingPartError, match=r"'foo_msgs' of foo_msgs/msg/Bar isn't available here"):
        load_type("foo_msgs/msg/Bar")


def test_a_message_may_be_written_as_ros_1_did():
    assert load_message("std_msgs/String") is load_message("std_msgs/msg/String")
    with pytest.raises(UnknownNameError, match="package/msg/Name"):
        load_message("String")
