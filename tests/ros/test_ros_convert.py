"""Values go through messages and come back the same; what doesn't fit is refused with the field that doesn't."""

from __future__ import annotations

import tracemalloc
from array import array
from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import grip_bt.ros  # noqa: F401 - before any message package
from grip_bt.base.values import CameraInfo, DepthImage, Grasp, Image, JointState, PointCloud, Pose, Trajectory
from grip_bt.ros.client.types import ConversionError, load_type
from grip_bt.ros.convert import from_message, to_message

from geometry_msgs.msg import PoseStamped, TransformStamped  # isort: skip
from sensor_msgs.msg import Image as ImageMessage  # isort: skip
from sensor_msgs.msg import PointCloud2, PointField  # isort: skip

RNG = np.random.default_rng(5)
POSE = Pose([1, 2, 3], [0.1, 0.2, 0.3, 0.9], "cam")
GRASP = Grasp(POSE, POSE.moved([0, 0, 1]), POSE, width=0.05, quality=0.5)
CAMERA = CameraInfo(4, 3, [[300, 0, 2.0], [0, 301, 1.5], [0, 0, 1]], Pose(frame="optical"))


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (POSE, "geometry_msgs/msg/PoseStamped"),
        (POSE, "geometry_msgs/msg/TransformStamped"),
        (Pose([1, 2, 3], [0, 1, 0, 0]), "geometry_msgs/msg/Pose"),
        (Pose([1, 2, 3], [0, 1, 0, 0]), "geometry_msgs/msg/Transform"),
        (JointState(("a", "b"), [1, 2], [3, 4], None, 1.5), "sensor_msgs/msg/JointState"),
        (JointState(("a",), [1], None, [2.5], 0.25), "sensor_msgs/msg/JointState"),
        (Trajectory(("a", "b"), [0, 0.5], [[1, 2], [3, 4]]), "trajectory_msgs/msg/JointTrajectory"),
        (Trajectory(("a",), [0, 0.5], [[1], [2]], [[3], [4]], [[5], [6]]), "trajectory_msgs/msg/JointTrajectory"),
        (Image(RNG.integers(0, 255, (3, 4, 3), np.uint8), "cam", 2.0), "sensor_msgs/msg/Image"),
        (CAMERA, "sensor_msgs/msg/CameraInfo"),
        (PointCloud(RNG.random((7, 3)), None, "cam", 1.25), "sensor_msgs/msg/PointCloud2"),
        (PointCloud(RNG.random((7, 3)), RNG.integers(0, 255, (7, 3))), "sensor_msgs/msg/PointCloud2"),
        (PointCloud(np.zeros((0, 3)), np.zeros((0, 3))), "sensor_msgs/msg/PointCloud2"),
        (3.5, "std_msgs/msg/Float64"),
        ("word", "std_msgs/msg/String"),
        (True, "std_msgs/msg/Bool"),
    ],
)
def test_a_value_comes_back_as_it_went(value, message):
    sent = to_message(value, load_type(message))
    assert from_message(sent, type(value).__name__) == value


def test_quaternions_change_their_order_at_the_door_only():
    q = to_message(POSE, PoseStamped).pose.orientation
    assert np.allclose([q.w, q.x, q.y, q.z], POSE.quaternion)
    r = to_message(POSE, TransformStamped).transform.rotation
    assert (r.w, r.x) == (q.w, q.x)


def test_a_pose_without_a_frame_is_given_in_world():
    assert from_message(PoseStamped(), "Pose").frame == "world"


@given(st.integers(0, 40), st.booleans(), st.floats(0, 1e6).map(lambda t: round(t, 3)))
def test_any_cloud_comes_back(n, colored, time):
    cloud = PointCloud(RNG.normal(size=(n, 3)), RNG.integers(0, 256, (n, 3)) if colored else None, "f", time)
    back = from_message(to_message(cloud, PointCloud2), "PointCloud")
    assert np.array_equal(back.points, cloud.points)
    assert colored == (back.colors is not None)
    assert not colored or np.array_equal(back.colors, cloud.colors)
    assert abs(back.time - time) < 1e-6


@pytest.mark.parametrize("big", [False, True])
@pytest.mark.parametrize("kind", ["f4", "f8"])
@pytest.mark.parametrize("gap", [0, 3])
def test_clouds_of_other_makers_are_read(big, kind, gap):
    size = int(kind[1])
    rows, columns, step = 2, 3, 1 + 3 * (size + gap) + 4
    row_step = columns * step + 5
    points = RNG.random((rows, columns, 3)).astype(kind)
    data = bytearray(rows * row_step)
    offsets = [1 + axis * (size + gap) for axis in range(3)]
    order = ">" if big else "<"
    for r in range(rows):
        for c in range(columns):
            start = r * row_step + c * step
            for axis, offset in enumerate(offsets):
                data[start + offset : start + offset + size] = np.array([points[r, c, axis]], order + kind).tobytes()
            rgb = np.array([0x00102030 + r * 16 + c], order + "u4")
            data[start + step - 4 : start + step] = rgb.tobytes()
    datatype = PointField.FLOAT32 if kind == "f4" else PointField.FLOAT64
    fields = [PointField(name=n, offset=o, datatype=datatype, count=1) for n, o in zip("xyz", offsets, strict=True)]
    fields.append(PointField(name="rgb", offset=step - 4, datatype=PointField.UINT32, count=1))
    message = PointCloud2(
        height=rows,
        width=columns,
        fields=fields,
        point_step=step,
        row_step=row_step,
        is_bigendian=big,
        is_dense=True,
        data=array("B", bytes(data)),
    )
    cloud = from_message(message, "PointCloud")
    assert np.array_equal(cloud.points, points.reshape(-1, 3).astype(np.float32))
    assert cloud.colors[4].tolist() == [0x10, 0x20, 0x30 + 16 + 1]


def test_points_that_nothing_was_seen_at_are_left_out():
    cloud = PointCloud([[0, 0, 1], [np.nan] * 3, [1, 1, 1]], [[1, 2, 3], [4, 5, 6], [7, 8, 9]])
    message = to_message(cloud, PointCloud2)
    assert not message.is_dense
    back = from_message(message, "PointCloud")
    assert back.points.tolist() == [[0, 0, 1], [1, 1, 1]]
    assert back.colors.tolist() == [[1, 2, 3], [7, 8, 9]]


@pytest.mark.parametrize(("field", "value"), [("row_step", 10_000), ("data", array("B", b"123")), ("fields", [])])
def test_a_cloud_that_contradicts_itself_is_refused(field, value):
    message = to_message(PointCloud(RNG.random((5, 3))), PointCloud2)
    setattr(message, field, value)
    with pytest.raises(ConversionError):
        from_message(message, "PointCloud")


def test_images_of_other_encodings_are_read_and_unknown_ones_refused():
    image_type = load_type("sensor_msgs/msg/Image")
    pixels = RNG.integers(0, 255, (2, 3, 4), np.uint8)
    message = image_type(height=2, width=3, encoding="bgra8", step=12, data=array("B", pixels.tobytes()))
    assert np.array_equal(from_message(message, "Image").pixels, pixels[:, :, 2::-1])
    message.encoding = "bayer_rggb8"
    with pytest.raises(ConversionError, match="encoding: 'bayer_rggb8' isn't one of rgb8"):
        from_message(message, "Image")


def test_depth_is_sent_in_metres():
    depth = DepthImage(RNG.random((3, 4)), CAMERA)
    message = to_message(depth, load_type("sensor_msgs/msg/Image"))
    assert (message.encoding, message.step) == ("32FC1", 16)
    assert np.array_equal(np.frombuffer(message.data, "f4").reshape(3, 4), depth.depth)


def test_a_dataclass_goes_by_the_names_of_its_fields(antipodal):
    candidate = load_type("antipodal_interfaces/msg/GraspCandidate")
    message = to_message(GRASP, candidate)
    assert message.quality == 0.5
    assert from_message([message, message], "list[Grasp]") == [GRASP, GRASP]


@dataclass
class Wrench:
    force: list[float] = field(default_factory=list)
    names: list[str] = field(default_factory=list)


def test_a_message_type_as_declared_type_is_left_alone():
    message = PoseStamped()
    assert from_message(message, "geometry_msgs/msg/PoseStamped") is message
    assert from_message(message) is message


@pytest.mark.parametrize(
    ("value", "told"),
    [
        ({"hight": 3}, "hight: sensor_msgs/msg/PointCloud2 has no such field; did you mean 'height'"),
        ({"height": -1}, "height: "),
        ({"height": 1.5}, "height: The 'height' field must be of type 'int'"),
        ({"height": True}, "height: uint32 expected"),
        ({"is_dense": 1}, "is_dense: The 'is_dense' field must be of type 'bool'"),
        ({"header": {"frame_id": 3}}, "header.frame_id: The 'frame_id' field must be of type 'str'"),
        ({"header": 3}, "header: a int can't be made a std_msgs/msg/Header"),
        ({"fields": [{"name": "x"}, {"name": 3}]}, r"fields\[1\].name: The 'name' field must be of type 'str'"),
        ({"fields": {"name": "x"}}, "fields: a list of sensor_msgs/PointField expected, got a dict"),
        ({"data": [1, 300]}, "data: uint8"),
        ({"data": [1.5]}, "data: uint8"),
        ({"data": "abc"}, "data: uint8"),
        (JointState((), []), "a JointState has no field in common"),
    ],
)
def test_what_does_not_fit_a_message_is_named_by_its_field(value, told):
    with pytest.raises(ConversionError, match=told):
        to_message(value, PointCloud2)


@pytest.mark.parametrize(
    ("declared", "told"),
    [
        ("Grasp", "geometry_msgs/msg/PoseStamped lacks the field 'pre_grasp' that a Grasp needs"),
        ("list[Pose]", "a sequence expected, got geometry_msgs/msg/PoseStamped"),
        ("float", "isn't a float"),
        ("Image", "lacks the field 'pixels'"),
    ],
)
def test_what_does_not_fit_a_declared_type_is_named(declared, told):
    with pytest.raises(ConversionError, match=told):
        from_message(PoseStamped(), declared)


def test_integers_become_floats_and_numbers_become_arrays():
    assert to_message({"data": 3}, load_type("std_msgs/msg/Float64")).data == 3.0
    several = to_message({"data": [1, 2]}, load_type("std_msgs/msg/Float64MultiArray"))
    assert several.data == array("d", [1.0, 2.0])
    assert to_message({"data": np.array([1, 2], np.int64)}, load_type("std_msgs/msg/UInt8MultiArray")).data == array(
        "B", [1, 2]
    )
    assert from_message(several.data, "list[float]") == [1.0, 2.0]


def test_a_quaternion_of_zeros_is_refused_with_its_field(antipodal):
    candidate = to_message(GRASP, load_type("antipodal_interfaces/msg/GraspCandidate"))
    q = candidate.pose.pose.orientation
    q.x = q.y = q.z = q.w = 0.0
    with pytest.raises(ConversionError, match=r"\[1\].pose: .*non-zero quaternion"):
        from_message([to_message(GRASP, type(candidate)), candidate], "list[Grasp]")


@pytest.mark.parametrize("kind", ["cloud", "coloured cloud", "image", "depth image"])
def test_what_is_big_is_copied_once(kind):
    big = {
        "cloud": lambda: PointCloud(np.zeros((100_000, 3), np.float32)),
        "coloured cloud": lambda: PointCloud(np.zeros((100_000, 3), np.float32), np.zeros((100_000, 3), np.uint8)),
        "image": lambda: Image(np.zeros((400, 1000, 3), np.uint8)),
        "depth image": lambda: DepthImage(
            np.ones((400, 1000), np.float32), CameraInfo(1000, 400, CAMERA.matrix, CAMERA.pose)
        ),
    }[kind]()
    message = {"cloud": PointCloud2, "image": ImageMessage}[kind.split()[-1]]
    tracemalloc.start()
    try:
        made = to_message(big, message)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert len(made.data) >= 1_000_000
    assert peak < 1.6 * len(made.data)
