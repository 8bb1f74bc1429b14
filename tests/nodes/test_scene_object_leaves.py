"""Leaves that change the planning scene; what they refuse is a failure of the task, and changes nothing."""

from __future__ import annotations

import numpy as np
import pytest

from grip_bt.base.errors import UnknownNameError
from grip_bt.base.values import PointCloud, Pose
from grip_bt.base.values.solids import Box, CellMap, Cylinder, Mesh, Sphere
from grip_bt.commanders.scene import PlanningScene

OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
SUCCESS = ("SUCCESS", "success", None)


@pytest.fixture
def scene(world, tmp_path):
    made = PlanningScene(
        {"right_hand": world.arm.grasp_pose},
        {"table": ((1, 1, 0.1), Pose((0.5, 0, -0.05)))},
        links={"right_hand": ("palm", "tip")},
        folder=tmp_path,
    )
    world.scene = world.context._scene = made
    return made


@pytest.mark.parametrize(
    ("shape", "size", "solid"),
    [
        ("box", [0.1, 0.2, 0.3], Box((0.1, 0.2, 0.3))),
        ("cylinder", [0.03, 0.1], Cylinder(0.03, 0.1)),
        ("sphere", [0.05], Sphere(0.05)),
    ],
)
def test_shapes_are_put_where_they_are_said_to_be(world, tick, scene, shape, size, solid):
    leaf = world.leaf("scene/add_shape", name="thing", shape=shape, size=size, position=[0.4, 0.1, 0.2])
    assert tick(leaf) == SUCCESS
    assert scene.solid("thing") == (solid, Pose((0.4, 0.1, 0.2)))
    turned = Pose((0.5, 0, 0.1), (0.5, 0.5, 0.5, 0.5))
    assert tick(world.leaf("scene/add_shape", name="thing", shape=shape, size=size, pose=turned)) == SUCCESS
    assert scene.solid("thing") == (solid, turned)


def test_a_wrong_shape_is_found_before_the_run(world, scene):
    with pytest.raises(UnknownNameError, match="did you mean 'cylinder'"):
        world.leaf("scene/add_shape", name="thing", shape="cilinder", size=[1.0, 1.0])
    with pytest.raises(ValueError, match="a box has 3 lengths"):
        world.leaf("scene/add_shape", name="thing", size=[1.0])
    with pytest.raises(ValueError, match="positive"):
        world.leaf("scene/add_shape", name="thing", shape="sphere", size=[-1.0])


def test_what_belongs_to_the_room_is_neither_replaced_nor_removed_nor_attached(world, tick, scene):
    before = scene.snapshot()
    refused = ("FAILURE", "failure", "no_object")
    assert tick(world.leaf("scene/add_shape", name="table", shape="sphere", size=[0.1])) == refused
    assert tick(world.leaf("scene/add_mesh", name="table", file="corner.obj")) == refused
    assert tick(world.leaf("scene/remove", name="table")) == refused
    assert tick(world.leaf("scene/attach", name="table")) == refused
    assert tick(world.leaf("scene/remove", name="*")) == SUCCESS
    assert world.data["count"] == 0
    assert scene.snapshot() == before


def test_a_mesh_is_read_from_the_project(world, tick, scene, tmp_path):
    (tmp_path / "corner.obj").write_text(OBJ)
    leaf = world.leaf("scene/add_mesh", name="corner", file="corner.obj", scale=[0.1, 0.1, 0.1], position=[1.0, 0, 0])
    assert tick(leaf) == SUCCESS
    solid, pose = scene.solid("corner")
    assert isinstance(solid, Mesh)
    assert pose == Pose((1, 0, 0))
    assert scene.box("corner")[1].position == pytest.approx([1.05, 0.05, 0.05])
    missing = world.leaf("scene/add_mesh", name="x", file="nowhere.stl")
    assert tick(missing) == ("FAILURE", "failure", "bad_file")
    assert "nowhere.stl" in missing.failure.message
    assert "x" not in scene.names()


def test_a_cloud_becomes_cells_above_the_table(world, tick, scene):
    rng = np.random.default_rng(0)
    points = rng.uniform((0.4, 0.0, -0.02), (0.5, 0.1, 0.1), (20_000, 3)).astype(np.float32)
    assert tick(world.leaf("scene/add_cloud", cloud=PointCloud(points), resolution=0.02)) == SUCCESS
    solid, _ = scene.solid("cloud")
    assert isinstance(solid, CellMap)
    assert world.data["cells"] == len(solid.cells)
    assert scene.box("cloud")[0] == pytest.approx([0.1, 0.1, 0.1], abs=0.021)
    low = PointCloud(np.full((3, 3), -1.0, np.float32))
    assert tick(world.leaf("scene/add_cloud", cloud=low)) == ("FAILURE", "failure", "no_data")
    elsewhere = PointCloud(points, frame="camera")
    assert tick(world.leaf("scene/add_cloud", cloud=elsewhere)) == ("FAILURE", "failure", "no_data")


def test_a_scene_file_is_loaded_or_the_reason_is_a_failure(world, tick, scene, tmp_path):
    (tmp_path / "room.scene").write_text(
        "(noname)+\n* ball\n0 0 1\n0 0 0 1\n1\nsphere\n0.1\n0 0 0\n0 0 0 1\n0 0 0 0\n0\n.\n"
    )
    assert tick(world.leaf("scene/load", file="room.scene")) == SUCCESS
    assert world.data["names"] == ["ball"]
    assert scene.solid("ball") == (Sphere(0.1), Pose((0, 0, 1)))
    (tmp_path / "bad.scene").write_text("(noname)+\n* ball\n1\nsfere\n.\n")
    leaf = world.leaf("scene/load", file="bad.scene")
    assert tick(leaf) == ("FAILURE", "failure", "bad_file")
    assert "sphere" in leaf.failure.message


def test_objects_are_removed_by_name_or_pattern(world, tick, scene):
    for name in ("seen_0", "seen_1", "mug"):
        scene.put(name, Sphere(0.1), Pose())
    assert tick(world.leaf("scene/remove", name="seen_*")) == SUCCESS
    assert world.data["count"] == 2
    assert tick(world.leaf("scene/remove", name="mug")) == SUCCESS
    leaf = world.leaf("scene/remove", name="mug")
    assert tick(leaf) == ("FAILURE", "failure", "no_object")
    assert leaf.failure.data["objects"] == ["table"]


def test_an_object_moves_with_the_hand_between_attaching_and_detaching(world, tick, scene):
    scene.put("mug", Sphere(0.03), world.arm.grasp_pose())
    assert tick(world.leaf("scene/attach", name="mug")) == SUCCESS
    world.arm.pose = world.arm.pose.moved((0, 0, 0.2))
    assert scene.box("mug")[1].position == pytest.approx(world.arm.pose.position)
    assert tick(world.leaf("scene/detach", name="mug")) == SUCCESS
    assert scene.attached("right_hand") == ()
    for node in ("scene/attach", "scene/detach"):
        assert tick(world.leaf(node, name="mgu")) == ("FAILURE", "failure", "no_object")


def test_collisions_are_allowed_and_forbidden_again(world, tick, scene):
    scene.put("mug", Sphere(0.03), Pose())
    assert tick(world.leaf("scene/allow_collisions", one="right_hand", other="mug")) == SUCCESS
    assert scene.snapshot().may_touch("mug", "tip")
    assert tick(world.leaf("scene/allow_collisions", one="mug", other="right_hand", allowed=False)) == SUCCESS
    assert not scene.snapshot().may_touch("mug", "tip")
    leaf = world.leaf("scene/allow_collisions", one="mgu", other="*")
    assert tick(leaf) == ("FAILURE", "failure", "no_object")


def test_the_scene_goes_back_to_a_snapshot(world, tick, scene):
    scene.put("mug", Sphere(0.03), Pose())
    assert tick(world.leaf("scene/snapshot")) == SUCCESS
    scene.remove("mug")
    assert tick(world.leaf("scene/restore", snapshot=world.data["snapshot"])) == SUCCESS
    assert "mug" in scene.names()
