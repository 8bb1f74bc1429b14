"""Declared conversions: units, frames, orders of quaternions, and fields deep in a message."""

from __future__ import annotations

import numpy as np
import pytest

import grip_bt.ros  # noqa: F401 - its settings come before any message package
from grip_bt.base.types import check_value
from grip_bt.base.values import Grasp, JointState, PointCloud, Pose
from grip_bt.ros.client.types import ConversionError
from grip_bt.ros.command import child_environment
from grip_bt.ros.component import Adapter, scaled
from grip_bt.ros.frames import FrameError, FrameTree, frame_of, transformed
from grip_bt.task.catalog.component_file import ComponentFile

pytestmark = pytest.mark.ros
QUARTER = Pose((1.0, 0.0, 0.0), (np.sqrt(0.5), 0, 0, np.sqrt(0.5)), "world")  # a quarter turn about z


def adapter(ports, frames=None, **more):
    file = {"name": "c", "interface": "p/srv/S", "server": "/s", "outcomes": 1, "ports": ports, **more}
    return Adapter(ComponentFile.model_validate(file), frames)


def test_a_port_is_put_deep_into_a_message_with_what_is_fixed():
    from geometry_msgs.msg import PoseStamped

    made = adapter(
        {"height": {"type": "float", "field": "pose.position.z", "unit": "cm"}},
        fixed={"header": {"frame_id": "table"}},
    ).pack({"height": 0.25}, PoseStamped)
    assert (made.pose.position.z, made.header.frame_id) == (25.0, "table")


def test_a_field_deep_in_a_message_is_taken_out_in_si_units():
    from geometry_msgs.msg import PoseStamped

    message = PoseStamped()
    message.pose.position.z = 250.0
    port = {"height": {"type": "float", "field": "pose.position.z", "unit": "mm"}}
    assert adapter(port).unpack(message, "height", "pose.position.z") == pytest.approx(0.25)


def test_a_field_that_is_not_there_is_named_with_what_is():
    from geometry_msgs.msg import PoseStamped

    with pytest.raises(ConversionError, match=r"pose\.positon: geometry_msgs/msg/Pose has no such field; did you mean"):
        adapter({"x": {"type": "float", "field": "pose.positon"}}).pack({"x": 1.0}, PoseStamped)


@pytest.mark.parametrize(("order", "numbers"), [("xyzw", [0, 0, 0.6, 0.8]), ("wxyz", [0.8, 0, 0, 0.6])])
def test_a_pose_goes_into_seven_numbers_and_back_in_the_declared_order(order, numbers):
    from std_msgs.msg import Float64MultiArray

    port = {"target": {"type": "Pose", "field": "data", "quaternion": order, "unit": "mm", "frame": "base"}}
    pose = Pose((0.1, 0.2, 0.3), (0.8, 0, 0, 0.6), "base")
    made = adapter(port)
    message = made.pack({"target": pose}, Float64MultiArray)
    assert list(message.data) == pytest.approx([100, 200, 300, *numbers])
    back = made.unpack(message, "target", "data")
    assert np.allclose(back.position, pose.position)
    assert np.allclose(back.quaternion, pose.quaternion)
    assert back.frame == "base"


def test_a_wrong_number_of_numbers_is_no_pose():
    from std_msgs.msg import Float64MultiArray

    port = {"target": {"type": "Pose", "field": "data"}}
    with pytest.raises(ConversionError, match="7 numbers .*these are 5"):
        adapter(port).unpack(Float64MultiArray(data=[1.0] * 5), "target", "data")


def test_a_value_is_sent_in_the_frame_that_the_component_works_in():
    from geometry_msgs.msg import PoseStamped

    frames = FrameTree({"camera": QUARTER})
    port = {"target": {"type": "Pose", "field": "pose", "frame": "camera"}}
    message = adapter(port, frames).pack({"target": Pose((1.0, 1.0, 0.0), frame="world")}, PoseStamped)
    assert (message.pose.position.x, message.pose.position.y) == (pytest.approx(1.0), pytest.approx(0.0))
    with pytest.raises(ConversionError, match="given in 'nowhere' and wanted in 'camera': unknown frame 'nowhere'"):
        adapter(port, frames).pack({"target": Pose(frame="nowhere")}, PoseStamped)


def test_what_comes_without_a_frame_gets_the_declared_one_and_what_names_one_keeps_it():
    from geometry_msgs.msg import Pose as PoseMessage
    from geometry_msgs.msg import PoseStamped

    port = {"target": {"type": "Pose", "frame": "camera"}}
    assert adapter(port).unpack(_holder(PoseMessage()), "target", "pose").frame == "camera"
    named = PoseStamped()
    named.header.frame_id = "base"
    assert adapter(port)._inwards(Pose(frame="base"), adapter(port)._file.ports["target"], named).frame == "base"


def _holder(pose):
    from geometry_msgs.msg import PoseStamped

    return PoseStamped(pose=pose)


@pytest.mark.parametrize(
    ("value", "unit", "wanted"),
    [(2, "cm", 0.02), ([1, 2], "mm", [0.001, 0.002]), (180.0, "deg", np.pi), (50, "percent", 0.5)],
)
def test_numbers_are_scaled(value, unit, wanted):
    from grip_bt.task.catalog.port_type import UNITS

    assert scaled(value, UNITS[unit], unit) == pytest.approx(wanted)


def test_values_are_scaled_where_they_have_such_a_quantity():
    assert scaled(Pose((1.0, 0, 0)), 0.001, "mm").position[0] == pytest.approx(0.001)
    assert scaled(PointCloud(np.ones((2, 3))), 0.001, "mm").points[0, 0] == pytest.approx(0.001)
    assert scaled(JointState(("a",), np.array([180.0])), np.pi / 180, "deg").position[0] == pytest.approx(np.pi)
    for wrong, unit in ((JointState(("a",), np.zeros(1)), "mm"), ("text", "mm"), (True, "mm")):
        with pytest.raises(ConversionError):
            scaled(wrong, 1.0, unit)


def test_frames_that_do_not_move_are_found_through_their_parents():
    urdf = """<robot name="r"><link name="base"/><link name="arm"/><link name="tool"/>
      <joint name="moves" type="revolute"><parent link="base"/><child link="arm"/></joint>
      <joint name="holds" type="fixed"><parent link="arm"/><child link="tool"/>
        <origin xyz="0 0 0.1" rpy="0 0 1.5707963"/></joint></robot>"""
    tree = FrameTree.of_urdf(urdf).with_poses({"camera": Pose((0, 0, 0.5), frame="tool")})
    assert tree.names == ("arm", "base", "camera", "tool", "world")
    assert np.allclose(tree.lookup("arm", "camera").position, (0, 0, 0.6))
    assert np.allclose(tree.lookup("camera", "arm").position, (0, 0, -0.6))
    assert tree.lookup("world", "base") == Pose(frame="world")
    with pytest.raises(FrameError, match="isn't connected with 'world' by fixed frames"):
        tree.lookup("world", "tool")
    with pytest.raises(FrameError, match="did you mean 'camera'"):
        tree.lookup("world", "camra")


def test_values_with_a_frame_are_transformed_as_a_whole():
    at = Pose((1.0, 0, 0), frame="camera")
    grasp = Grasp(at, at.moved((0, 0, -0.1)), at.moved((0, 0, 0.1)))
    seen = transformed([grasp], QUARTER)[0]
    assert frame_of(seen) == "world"
    assert np.allclose(seen.pose.position, (1, 1, 0))
    assert np.allclose(seen.pre_grasp.position, (1, 1, -0.1))
    assert np.allclose(transformed(PointCloud(np.array([[1.0, 0, 0]]), frame="camera"), QUARTER).points, [[1, 1, 0]])


@pytest.mark.parametrize(
    ("name", "given"), [("Int64MultiArray", [1, -2]), ("UInt8MultiArray", [1, 2]), ("Float64MultiArray", [0.5])]
)
def test_numbers_of_a_port_that_nobody_declares_are_a_list_as_its_manifest_says(name, given):
    from std_msgs import msg

    value = adapter({}).unpack(getattr(msg, name)(data=given), "data", "data")
    assert value == given
    assert check_value("list[int]" if name[0] != "F" else "list[float]", value) is None


def test_a_search_path_of_a_component_comes_before_ours(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", "/ours")
    found = child_environment(more={"PYTHONPATH": "/theirs", "MODE": "a"})
    assert found["PYTHONPATH"].split(":")[0] == "/theirs"
    assert "/ours" in found["PYTHONPATH"].split(":")
    assert found["MODE"] == "a"
