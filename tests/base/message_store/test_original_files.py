"""Files in the first GRIP's format: read whole, in any YAML, and refused with line and column."""

from __future__ import annotations

import math

import numpy as np
import pytest

from grip_bt.base.errors import DocumentError
from grip_bt.base.message_store import MessageLibrary, read_joint_states, read_poses, read_trajectories


def write(tmp_path, text, name="it.yaml"):
    file = tmp_path / name
    file.write_text(text)
    return file


def test_joint_states_in_block_and_flow_keep_every_digit(tmp_path):
    text = "above: {j1: 1.4901161193847656e-8, j2: 0.1}\nopen gripper:\n    j1: 0\n    j2: -0.30000000000000004\n"
    states = read_joint_states(write(tmp_path, text))
    assert states["above"].as_mapping() == {"j1": 1.4901161193847656e-8, "j2": 0.1}
    assert states["open gripper"].as_mapping() == {"j1": 0.0, "j2": -0.30000000000000004}


def test_poses_by_angles_and_by_quaternions(tmp_path):
    text = f"""
turned: {{reference_frame: world, position: {{x: 1, y: 2, z: 3}}, orientation: {{r: 0.1, p: -0.2, y: {math.pi / 2}}}}}
direct: {{reference_frame: base, position: {{x: 0, y: 0, z: 0}}, orientation: {{x: 0, y: 0, z: 1, w: 0}}}}
"""
    poses, several = read_poses(write(tmp_path, text))
    assert not several
    cr, sr, cp, sp = math.cos(0.1), math.sin(0.1), math.cos(-0.2), math.sin(-0.2)
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    assert poses["turned"].rotation() == pytest.approx(about_z @ about_y @ about_x)
    assert list(poses["direct"].quaternion) == [0, 0, 0, 1]
    assert poses["direct"].frame == "base"


def test_robot_poses_hold_several_end_effectors_in_one_frame(tmp_path):
    text = """
open_hand:
  reference_frame: palm_frame
  finger1: {position: {x: 0.1, y: 0.05, z: -0.03}, orientation: {r: -0.2, p: 0, y: 0}}
  finger2: {position: {x: 0.2, y: 0.05, z: -0.03}, orientation: {r: 0, p: 0, y: 0}}
"""
    poses, several = read_poses(write(tmp_path, text))
    assert not poses
    assert list(several["open_hand"]) == ["finger1", "finger2"]
    assert {pose.frame for pose in several["open_hand"].values()} == {"palm_frame"}


def test_a_trajectory_goes_through_its_way_points_and_stays_for_its_pauses(tmp_path):
    states = read_joint_states(write(tmp_path, "a: {j2: 1, j1: 0}\nb: {j1: 0.5, j2: 2}", "states.yaml"))
    text = """
there:
  - {name: a, interpolate_time: 0.1, pause_time: 0.2}
  - {name: b, interpolate_time: 0.4, pause_time: 0}
"""
    made = read_trajectories(write(tmp_path, text), states)["there"]
    assert made.names == ("j1", "j2")
    assert made.times == pytest.approx([0, 0.2, 0.6])
    assert made.positions.tolist() == [[0, 1], [0, 1], [0.5, 2]]


@pytest.mark.parametrize(
    ("reader", "text", "reason"),
    [
        (read_joint_states, "a: {j: high}", r":1:5: a/j: Input should be a valid number, not 'high'"),
        (read_joint_states, "a: {j: .nan}", "should be a finite number"),
        (read_joint_states, "a: {j: true}", "should be a valid number, not True"),
        (read_joint_states, "a: 3", "a: expected a mapping"),
        (read_joint_states, "a: {}", "'a' takes at least 1"),
        (read_joint_states, "[1]", "expected a mapping from names to values"),
        (read_joint_states, "a: {j: 1}\na: {j: 2}", ":2:1"),
        (read_joint_states, "a:\n\tj: 1", ":2"),
        (read_poses, "a: {position: {x: 0, y: 0, z: 0}}", "the key 'reference_frame' is missing"),
        (read_poses, "a: {reference_frame: w, position: {x: 0, y: 0, z: 0}}", "the key 'orientation' is missing"),
        (
            read_poses,
            "a: {reference_frame: w, position: {x: 0, y: 0}, orientation: {r: 0, p: 0, y: 0}}",
            "a position has x, y and z",
        ),
        (
            read_poses,
            "a: {reference_frame: w, position: {x: 0, y: 0, z: 0}, orientation: {r: 0, p: 0, z: 0}}",
            "an orientation has r, p, y",
        ),
        (
            read_poses,
            "a: {reference_frame: w, position: {x: 0, y: 0, z: 0}, orientatio: {r: 0, p: 0, y: 0}}",
            "unknown key 'orientatio' in a; did you mean 'orientation'",
        ),
        (read_poses, "a: {reference_frame: w}", "neither a pose"),
        (
            read_poses,
            "a: {reference_frame: w, position: {x: 0, y: 0, z: 0}, orientation: {x: 0, y: 0, z: 0, w: 0}}",
            "a: ",
        ),
    ],
)
def test_what_is_wrong_is_told_with_its_place(tmp_path, reader, text, reason):
    with pytest.raises(DocumentError, match=reason):
        reader(write(tmp_path, text))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("t: [{name: c, interpolate_time: 1, pause_time: 0}]", "no joint state 'c'"),
        ("t: [{name: a, interpolate_time: 1}]", "the key 'pause_time' is missing"),
        (
            "t: [{name: a, interpolate_time: 1, pause_time: 0}, {name: a, interpolate_time: 0, pause_time: 0}]",
            "'interpolate_time' is more than 0",
        ),
        (
            "t: [{name: a, interpolate_time: 1, pause_time: 0}, {name: b, interpolate_time: 1, pause_time: 0}]",
            "all way-points have the same joints",
        ),
        ("t: {}", "t: Input should be a valid list"),
    ],
)
def test_wrong_trajectories_are_told_with_their_place(tmp_path, text, reason):
    states = read_joint_states(write(tmp_path, "a: {j: 0}\nb: {k: 0}", "states.yaml"))
    with pytest.raises(DocumentError, match=reason):
        read_trajectories(write(tmp_path, text), states)


def test_a_library_has_what_the_files_of_its_folder_hold_with_their_names_as_provenance(tmp_path):
    write(tmp_path, "home: {j: 0}", "joint_states.yaml")
    write(tmp_path, "wave: [{name: home, interpolate_time: 1, pause_time: 1}]", "trajectories.yaml")
    write(tmp_path, "", "poses.yaml")
    library = MessageLibrary(tmp_path)
    assert library.store("joint_states").entry("home").provenance == str(tmp_path / "joint_states.yaml")
    assert library.store("trajectories").get("wave").duration == 1
    assert library.store("poses").names() == ()


def test_a_reset_returns_to_the_files_and_a_broken_file_changes_nothing(tmp_path):
    file = write(tmp_path, "home: {j: 0}", "joint_states.yaml")
    library = MessageLibrary(tmp_path)
    store = library.store("joint_states")
    store.put("mine", store.get("home"))
    file.write_text("home: [")
    with pytest.raises(DocumentError):
        library.reset()
    assert store.names() == ("home", "mine")
    file.write_text("rest: {j: 1}")
    library.reset("joint_states")
    assert store.names() == ("rest",)
