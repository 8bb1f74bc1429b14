import numpy as np
import pytest
from py_trees.common import Status

from grip_bt.base.values import PointCloud, Pose
from grip_bt.commanders.scene import PlanningScene


def top_of(x, y, half=0.03, height=0.15, yaw=0.0, n=25):
    """Points on the top of a square prism."""
    a = np.linspace(-half, half, n)
    u, v = (m.ravel() for m in np.meshgrid(a, a))
    c, s = np.cos(yaw), np.sin(yaw)
    return np.stack([x + c * u - s * v, y + s * u + c * v, np.full(u.shape, height)], axis=1)


def cloud(*parts):
    table = np.stack([*(m.ravel() for m in np.meshgrid(np.linspace(0.3, 0.9, 60), np.linspace(-0.5, 0.5, 90)))])
    points = np.vstack([np.column_stack([table.T, np.zeros(table.shape[1])]), *parts])
    return PointCloud(points.astype(np.float32))


def seen(world):
    return sorted(n for n in world.scene.names() if n.startswith("seen_"))


def test_each_thing_becomes_an_upright_box_from_the_table_to_its_top(world, tick):
    leaf = world.leaf("scene/update_from_cloud", cloud=cloud(top_of(0.5, 0.0, yaw=0.4), top_of(0.5, 0.2, 0.02, 0.1)))
    assert tick(leaf) == ("SUCCESS", "success", None)
    assert world.data["count"] == 2
    assert seen(world) == ["seen_0", "seen_1"]
    size, pose = world.scene.box("seen_0" if abs(world.scene.box("seen_0")[1].position[1]) < 0.1 else "seen_1")
    np.testing.assert_allclose(size, [0.06, 0.06, 0.147], atol=1e-3)
    np.testing.assert_allclose(pose.position, [0.5, 0.0, 0.0765], atol=1e-3)
    np.testing.assert_allclose(pose.rotation()[:, 2], [0, 0, 1], atol=1e-9)
    corner = pose.apply([[0.03, 0.03, 0.0]])[0, :2] - [0.5, 0.0]
    angle = (np.arctan2(corner[1], corner[0]) - np.pi / 4 - 0.4 + np.pi / 4) % (np.pi / 2) - np.pi / 4
    assert abs(angle) < 0.03


def test_what_is_gone_leaves_the_scene_and_the_room_stays(world, tick):
    world.stand("seen_7", (0.6, 0.3))
    fixed = [n for n in world.scene.names() if n.startswith(("crate", "table"))]
    assert tick(world.leaf("scene/update_from_cloud", cloud=cloud())) == ("SUCCESS", "success", None)
    assert world.data["count"] == 0
    assert seen(world) == []
    assert list(world.scene.names()) == fixed


def test_what_lies_in_the_target_is_left_to_the_account_of_placing(world, tick):
    world.scene.set_box("placed_0", [0.06, 0.06, 0.15], Pose([0.45, -0.45, 0.078]))
    wall = np.column_stack([np.linspace(0.35, 0.61, 200), np.full(200, -0.245), np.full(200, 0.06)])
    leaf = world.leaf("scene/update_from_cloud", cloud=cloud(top_of(0.45, -0.45), wall, top_of(0.5, 0.1)))
    tick(leaf)
    assert world.data["count"] == 1
    assert "placed_0" in world.scene.names()


def test_boxes_of_the_room_are_not_seen_as_things_and_what_stands_before_them_is(world, tick):
    board = ([0.02, 0.3, 0.4], Pose([0.7, 0.2, 0.2]))
    world.context._scene = world.scene = PlanningScene({"right_hand": world.arm.grasp_pose}, {"board": board})
    y, z = (m.ravel() for m in np.meshgrid(np.linspace(0.05, 0.35, 60), np.linspace(0, 0.4, 80)))
    face = np.stack([np.full(y.shape, 0.689), y, z], axis=1)
    leaf = world.leaf("scene/update_from_cloud", cloud=cloud(face, top_of(0.6, 0.2)), target="")
    tick(leaf)
    assert world.data["count"] == 1
    (name,) = seen(world)
    np.testing.assert_allclose(world.scene.box(name)[1].position[:2], [0.6, 0.2], atol=0.01)


def test_what_the_hand_holds_stays_attached_and_is_not_seen_twice(world, tick):
    world.hold()
    (held,) = world.scene.attached("right_hand")
    size, pose = world.scene.box(held)
    points = pose.apply(np.random.default_rng(0).uniform(-0.5, 0.5, (400, 3)) * size)
    tick(world.leaf("scene/update_from_cloud", cloud=cloud(points, top_of(0.5, 0.3))))
    assert world.data["count"] == 1
    assert world.scene.attached("right_hand") == (held,)


def test_specks_and_what_is_high_above_the_table_are_ignored(world, tick):
    speck = top_of(0.5, 0.0, half=0.002, n=3)
    robot = top_of(0.5, 0.2, height=0.6)
    lost = np.full((5, 3), np.nan)
    tick(world.leaf("scene/update_from_cloud", cloud=cloud(speck, robot, lost)))
    assert world.data["count"] == 0


@pytest.mark.parametrize(
    ("bad", "why"),
    [(PointCloud(np.zeros((0, 3))), "no points"), (PointCloud(np.ones((9, 3)), frame="camera"), "'camera'")],
)
def test_a_cloud_that_says_nothing_about_the_world_is_the_failure_no_data(world, tick, bad, why):
    world.stand()
    leaf = world.leaf("scene/update_from_cloud", cloud=bad)
    assert tick(leaf) == ("FAILURE", "failure", "no_data")
    assert why in leaf.failure.message
    assert seen(world) == ["seen_0"]


def test_the_work_is_done_in_a_worker_and_a_halted_leaf_changes_nothing(world):
    world.stand("seen_9")
    world.context.defer = True
    leaf = world.leaf("scene/update_from_cloud", cloud=cloud(top_of(0.5, 0.1)))
    leaf.tick_once()
    assert leaf.status == Status.RUNNING
    leaf.stop(Status.INVALID)
    world.context.work()
    assert seen(world) == ["seen_9"]
