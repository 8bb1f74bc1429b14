"""The ray-cast camera against what geometry says that it must see."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from grip_bt.base.values import DepthImage, Image, Pose, RgbdFrame
from grip_sim.specs import CameraSpec, ObjectSpec, WorldSpec
from grip_sim.worlds import load_world

pytestmark = pytest.mark.sim
CYLINDER = ObjectSpec("cylinder", "cylinder", 0.03, 0.16, (0.46, 0.05, 0.08), colour=(200, 60, 40))
BOX = ObjectSpec("box", "box", 0.032, 0.14, (0.58, 0.22, 0.07), yaw=0.4, colour=(60, 150, 70))
LEVEL = Pose.from_matrix([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])  # looks along +y, image up = +z
SIDE = CameraSpec("side", 160, 120, 0.5, (0.46, -0.95, 0.0805), tuple(LEVEL.quaternion.tolist()))
SPEC = WorldSpec(objects=(CYLINDER, BOX), cameras=(CameraSpec(), SIDE))


PICK_X, PICK_Y = (0.42, 0.64), (-0.08, 0.32)


@pytest.fixture(scope="module")
def world():
    from grip_sim.world import World

    made = World(SPEC)
    for _ in range(60):
        made.step()
    return made


@pytest.fixture(scope="module")
def overhead(world):
    return world.cameras.look("overhead")


def looked_down_upon(height):
    """Return where each pixel's ray meets the level `height`: x, y of shape (rows, columns)."""
    camera = CameraSpec()
    pixels = np.mgrid[0 : camera.height, 0 : camera.width]
    focal = camera.height / 2 / np.tan(camera.field_of_view / 2)
    scale = (camera.position[2] - height) / focal
    up, right = camera.height / 2 - pixels[0] - 0.5, pixels[1] + 0.5 - camera.width / 2
    return camera.position[0] + up * scale, camera.position[1] - right * scale


def within_box(x, y, half):
    dx, dy = x - BOX.position[0], y - BOX.position[1]
    c, s = np.cos(BOX.yaw), np.sin(BOX.yaw)
    return np.maximum(np.abs(c * dx + s * dy), np.abs(-s * dx + c * dy)) < half


def test_the_top_of_a_cylinder_is_seen_where_it_is_and_as_far_as_it_is(overhead):
    x, y = looked_down_upon(CYLINDER.height)
    top = np.hypot(x - CYLINDER.position[0], y - CYLINDER.position[1]) < 0.95 * CYLINDER.radius
    assert top.sum() > 300
    assert overhead.depth[top] == pytest.approx(1.30 - CYLINDER.height, abs=1e-3)
    assert {overhead.names[label] for label in np.unique(overhead.labels[top])} == {"cylinder"}


def test_the_top_of_a_turned_box_is_seen_where_it_is_and_as_far_as_it_is(overhead):
    x, y = looked_down_upon(BOX.height)
    top = within_box(x, y, 0.97 * BOX.radius)
    assert top.sum() > 300
    assert overhead.depth[top] == pytest.approx(1.30 - BOX.height, abs=1e-3)
    assert {overhead.names[label] for label in np.unique(overhead.labels[top])} == {"box"}


def test_the_table_is_seen_around_them(overhead):
    seen = overhead.labels == overhead.names.index("table")
    assert seen.sum() > 10_000
    assert overhead.depth[seen] == pytest.approx(1.30, abs=1e-4)


def test_nothing_is_seen_that_the_geometry_does_not_have(overhead):
    # what differs from the table's level must lie between the shadows of an object's foot and of its top
    x, y = looked_down_upon(0.0)
    camera = np.array(CameraSpec().position[:2])
    grown = 1.30 / (1.30 - 0.16)
    may = np.zeros(x.shape, bool)
    for thing in SPEC.objects:
        reach = thing.radius * (1 if thing.shape == "cylinder" else np.sqrt(2)) * 1.05 + 0.002
        for part in np.linspace(1, grown, 20):
            cx, cy = camera + (np.array(thing.position[:2]) - camera) * part
            may |= np.hypot(x - cx, y - cy) < reach * part
    different = np.abs(overhead.depth - 1.30) > 1e-3
    inside = (x > PICK_X[0]) & (x < PICK_X[1]) & (y > PICK_Y[0]) & (y < PICK_Y[1])
    assert not (different & inside & ~may).any()


def test_the_front_of_a_cylinder_is_round_seen_from_the_side(world):
    frame, info = world.cameras.look("side"), SIDE.info()
    rays = info.rays()
    row = SIDE.height // 2
    labels = frame.labels[row]
    seen = labels == frame.names.index("cylinder")
    slope = rays[row, :, 0]  # sideways per metre of depth
    distance = CYLINDER.position[1] - SIDE.position[1]
    # the line (slope * d, d) meets the circle of this radius around (0, distance)
    a, b, c = 1 + slope**2, distance, distance**2 - CYLINDER.radius**2
    root = b * b - a * c
    inner = root > 0.1 * root.max()
    expected = (b - np.sqrt(np.where(inner, root, 0))) / a
    assert inner.sum() > 8
    assert seen[inner].all()
    assert frame.depth[row][inner] == pytest.approx(expected[inner], abs=1.5e-3)


def test_where_nothing_is_the_depth_is_zero_and_the_label_says_so(world):
    frame = world.cameras.look("side")
    assert (frame.labels == -1).any()
    assert (frame.depth[frame.labels == -1] == 0).all()
    assert (frame.depth[frame.labels != -1] > 0).all()


def test_the_points_of_a_cloud_lie_on_the_surfaces_of_the_objects(overhead):
    info = CameraSpec().info()
    cloud = RgbdFrame(Image(overhead.image), DepthImage(overhead.depth, info)).cloud()
    labels = overhead.labels.reshape(-1)[overhead.depth.reshape(-1) > 0]
    points = cloud.points[labels == overhead.names.index("cylinder")].astype(float)
    radial = np.hypot(*(points[:, :2] - CYLINDER.position[:2]).T)
    off = np.minimum(np.abs(points[:, 2] - CYLINDER.height), np.abs(radial - CYLINDER.radius))
    assert len(points) > 500
    assert off.max() < 1.5e-3
    assert radial.max() < CYLINDER.radius + 1.5e-3
    points = cloud.points[labels == overhead.names.index("box")].astype(float)
    assert (points[:, 2] < BOX.height + 1e-3).all()
    assert within_box(points[:, 0], points[:, 1], BOX.radius + 1e-3).all()


def test_entities_differ_in_colour(overhead):
    seen = {n: overhead.image[overhead.labels == i] for i, n in enumerate(overhead.names)}
    means = [pixels.mean(axis=0) for name, pixels in seen.items() if name in ("table", "cylinder", "box")]
    assert len(means) == 3
    assert all(np.linalg.norm(one - two) > 30 for one, two in itertools.combinations(means, 2))


def test_the_arm_at_home_hides_nothing_of_the_pick_region():
    from grip_sim.world import World

    made = World(load_world("table", 0))
    frame, info = made.cameras.look("overhead"), CameraSpec().info()
    x, y = np.meshgrid(np.arange(PICK_X[0], PICK_X[1], 0.01), np.arange(PICK_Y[0], PICK_Y[1], 0.01))
    robot = {link.name for link in made.robot.links}
    for height in (0.0, 0.17):
        grid = np.stack([x, y, np.full_like(x, height)], axis=-1).reshape(-1, 3)
        columns, rows = np.floor(info.project(grid)).astype(int).T
        inside = (columns >= 0) & (columns < info.width) & (rows >= 0) & (rows < info.height)
        assert inside.all()
        assert robot.isdisjoint(frame.names[label] for label in np.unique(frame.labels[rows, columns]))


def test_a_frame_shows_an_object_where_it_is_now(world):
    before = world.object_pose("box")
    x, y = looked_down_upon(0.0)
    there = np.hypot(x - 0.62, y + 0.02) < 0.015
    world.move_object("box", Pose([0.62, -0.02, 0.07]))
    moved = world.cameras.look("overhead")
    world.move_object("box", before)
    again = world.cameras.look("overhead")
    assert {moved.names[label] for label in np.unique(moved.labels[there])} == {"box"}
    assert {again.names[label] for label in np.unique(again.labels[there])} == {"table"}


def test_two_frames_of_the_same_scene_are_equal(world):
    one, two = world.cameras.look("overhead"), world.cameras.look("overhead")
    assert np.array_equal(one.image, two.image)
    assert np.array_equal(one.depth, two.depth)
