"""Values are frozen, own their arrays, and state what is wrong with bad input."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grip_bt.base.values import (
    CameraInfo,
    DepthImage,
    Grasp,
    Image,
    JointState,
    PointCloud,
    Pose,
    RgbdFrame,
    Trajectory,
)

number = st.floats(-3, 3, allow_nan=False)
vectors = st.tuples(number, number, number)
quaternions = st.tuples(number, number, number, number).filter(lambda q: np.linalg.norm(q) > 0.1)
poses = st.builds(Pose, vectors, quaternions)


@given(poses)
def test_a_pose_survives_the_way_through_its_matrix(pose):
    again = Pose.from_matrix(pose.matrix())
    assert np.allclose(again.position, pose.position)
    assert abs(np.dot(again.quaternion, pose.quaternion)) == pytest.approx(1, abs=1e-9)


@given(poses)
def test_a_pose_composed_with_its_inverse_is_the_identity(pose):
    assert np.allclose((pose @ pose.inverse()).matrix(), np.eye(4), atol=1e-9)


@given(poses, poses, vectors)
def test_composing_poses_maps_points_one_after_the_other(first, second, point):
    assert np.allclose((first @ second).apply([point]), first.apply(second.apply([point])), atol=1e-9)


@given(poses)
def test_rotations_are_orthonormal_and_right_handed(pose):
    rotation = pose.rotation()
    assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1)


def test_arrays_are_copied_and_read_only():
    source = np.zeros(3)
    pose = Pose(source)
    source[0] = 1
    assert pose.position[0] == 0
    with pytest.raises(ValueError, match="read-only"):
        pose.position[0] = 1


@pytest.mark.parametrize("quaternion", [(0, 0, 0, 0), (np.nan, 0, 0, 1)])
def test_a_pose_refuses_a_quaternion_without_direction(quaternion):
    with pytest.raises(ValueError, match="non-zero quaternion"):
        Pose((0, 0, 0), quaternion)


def test_a_wrong_shape_is_named():
    with pytest.raises(ValueError, match=r"position has shape \(2,\), not \(3,\)"):
        Pose((0, 0))


def test_equality_compares_arrays_by_content():
    assert Pose((1, 2, 3)) == Pose((1, 2, 3))
    assert Pose((1, 2, 3)) != Pose((1, 2, 4))
    assert Pose((1, 2, 3)) != "a pose"


def test_joint_states_answer_by_name():
    state = JointState.from_mapping({"a": 1.0, "b": 2.0})
    assert list(state.ordered(("b", "a"))) == [2.0, 1.0]
    with pytest.raises(KeyError):
        state.ordered(("c",))


@pytest.mark.parametrize("times", [[0.5, 1], [0, 0], [0, 1, 0.5], []])
def test_a_trajectory_refuses_times_that_do_not_increase_from_zero(times):
    with pytest.raises(ValueError, match="start at 0 and increase"):
        Trajectory(("a",), times, np.zeros((len(times), 1)))


def test_a_trajectory_is_linear_between_its_points_and_clamped():
    trajectory = Trajectory(("a",), [0, 2], [[0], [4]])
    assert [trajectory.at(t)[0] for t in (-1, 1, 5)] == [0, 2, 4]
    assert trajectory.duration == 2
    assert trajectory.end().as_mapping() == {"a": 4.0}


def test_the_poses_of_a_grasp_are_given_in_one_frame():
    with pytest.raises(ValueError, match="one frame"):
        Grasp(Pose(), Pose(frame="camera"), Pose())


def _frame() -> RgbdFrame:
    matrix = np.array([[100, 0, 2], [0, 100, 1.5], [0, 0, 1.0]])
    down = Pose((0.5, 0, 1.0), (0, 1, 0, 0))
    depth = np.full((3, 4), 1.0, np.float32)
    depth[0, 0] = 0
    return RgbdFrame(Image(np.zeros((3, 4, 3), np.uint8)), DepthImage(depth, CameraInfo(4, 3, matrix, down)))


def test_a_cloud_holds_only_what_was_seen_and_projects_back_to_its_pixels():
    frame = _frame()
    cloud = frame.cloud()
    assert cloud.points.shape == (11, 3)
    assert np.allclose(cloud.points[:, 2], 0, atol=1e-6)
    pixels = frame.depth.info.project(cloud.points)
    assert np.allclose(pixels[0], [1.5, 0.5], atol=1e-3)


def test_depth_and_camera_must_agree_in_size():
    with pytest.raises(ValueError, match="depth has shape"):
        DepthImage(np.zeros((2, 2)), CameraInfo(4, 3, np.eye(3)))


def test_a_cloud_refuses_colours_of_another_length():
    with pytest.raises(ValueError, match="colors has shape"):
        PointCloud(np.zeros((2, 3)), np.zeros((3, 3)))


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("place", [(0, 0), (1, 1), (2, 2), (0, 3), (2, 3)])
def test_a_matrix_that_is_not_finite_makes_no_pose(place, wrong):
    matrix = np.eye(4)
    matrix[place] = wrong
    with pytest.raises(ValueError, match="finite"):
        Pose.from_matrix(matrix)


def test_a_pose_of_a_matrix_is_exact_to_the_last_bit_where_it_can_be():
    for turned in (np.eye(3), np.diag([1, -1, -1]), np.diag([-1, 1, -1]), np.diag([-1, -1, 1])):
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = turned, (0.1, -2.0, 3e300)
        pose = Pose.from_matrix(matrix)
        assert np.array_equal(pose.rotation(), turned)
        assert np.array_equal(pose.position, matrix[:3, 3])
